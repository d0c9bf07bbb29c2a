"""Spherical harmonics: basis, grids, rotations, and shapes described by coefficients."""

#: Degrees that are expanded at the most: time grows by their cube, 1,000 takes minutes; (L + 1)^2 is a million.
LARGEST_DEGREE = 1000
