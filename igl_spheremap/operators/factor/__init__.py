"""Factors of sparse symmetric positive definite matrices, exact or approximate."""
