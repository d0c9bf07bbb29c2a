"""Spherical harmonics: basis, grids, rotations, and shapes described by coefficients."""
