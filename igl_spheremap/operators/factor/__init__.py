"""Exact factors of sparse symmetric positive definite matrices, and the orders of elimination that keep them sparse."""
