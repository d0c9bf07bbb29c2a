"""L, M and the inverse of P: matrices of a mesh and their factorisation."""
