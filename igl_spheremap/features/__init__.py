"""The depth of a surface's folds, and data smoothed on it."""
