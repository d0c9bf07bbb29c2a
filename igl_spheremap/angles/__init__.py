"""Angles lowered: layouts by angles as new starts, and steps that bring a map's angles nearer to its mesh's."""
