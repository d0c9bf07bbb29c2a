"""How deep the folds of a surface are, and data smoothed on it."""
