"""Foldings removed: the least change of a map after which no face is folded."""
