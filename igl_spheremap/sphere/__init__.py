"""Geometry of the unit sphere."""
