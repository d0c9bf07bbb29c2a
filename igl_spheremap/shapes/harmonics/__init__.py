"""Values and shapes on the sphere as sums of spherical harmonics, and on grids."""

#: Degrees that are expanded at most: time grows by their cube, 1,000 takes minutes; (L + 1)^2 is a million.
LARGEST_DEGREE = 1000
