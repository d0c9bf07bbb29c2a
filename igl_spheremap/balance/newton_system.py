"""Sparse systems of one pattern, two unknowns a vertex: analysed once, factorised at every step."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from ..errors import FactorisationFailed
from ..mesh.arrays import FloatArray, IntArray
from ..mesh.edges import edge_keys
from ..operators.factor.factorize import available_backends
from ..operators.factor.ordering import bandwidth_order, nested_dissection
from .derivatives import PAIRS, Derivatives

Solver = Callable[[FloatArray, FloatArray], FloatArray]

#: Added to the diagonal, as a share of it: rotations of the sphere cost nothing.
_DAMPING = 1e-8


class NewtonSystem:
    """Newton's equations on the faces `f` of `n` vertices.

    The matrix is kept as the lower triangle of its fill-reducing order, column by column.
    """

    def __init__(self, f: IntArray, n: int, backend: str = "auto") -> None:
        cholmod = backend == "cvxopt" or (backend == "auto" and "cvxopt" in available_backends())
        corners = f.T
        graph = sp.csr_matrix((np.ones(9 * len(f)), (np.repeat(corners, 3, axis=0).ravel(),
                                                     np.tile(corners, (3, 1)).ravel())), shape=(n, n))
        self.order = bandwidth_order(graph) if cholmod else nested_dissection(graph).order
        rank = np.empty(n, dtype=np.int64)
        rank[self.order] = np.arange(n)
        first, second = (rank[corners[list(column)]] for column in zip(*PAIRS, strict=True))
        blocks, self._block = np.unique(edge_keys(first, second, n), return_inverse=True)
        self._transposed = (first < second)[:, None, None]
        self._blocks, row, column = len(blocks), blocks % n, blocks // n
        # Entries (b, block, a) of the lower triangle are sorted by row within every column.
        a, b = np.arange(2), np.arange(2)[:, None, None]
        i, j, entry = np.broadcast_arrays(2 * row[:, None] + a, 2 * column[:, None] + b,
                                          (2 * a + b) * self._blocks + np.arange(self._blocks)[:, None])
        kept = i >= j
        A = sp.csc_matrix((entry[kept], (i[kept], j[kept])), shape=(2 * n, 2 * n))
        self._source, rows, columns = A.data, A.indices.astype(np.int64), np.repeat(np.arange(2 * n), np.diff(A.indptr))
        self._diagonal = A.indptr[:-1]
        self._solve = (_cholmod if cholmod else _superlu)(rows, columns, 2 * n)

    def step(self, d: Derivatives) -> FloatArray:
        """Newton step (2, n); FactorisationFailed where the Hessian isn't positive definite in floats."""
        blocks = np.where(self._transposed, d.blocks.transpose(0, 2, 1, 3), d.blocks)
        sums = np.stack([np.bincount(self._block.ravel(), blocks[:, a, b].ravel(), self._blocks)
                         for a in range(2) for b in range(2)])
        values = sums.ravel()[self._source]
        values[self._diagonal] *= 1 + _DAMPING
        if not np.isfinite(values).all():
            raise FactorisationFailed("the Hessian has entries that are not finite")
        step = np.empty_like(d.gradient)
        step[:, self.order] = self._solve(values, -d.gradient[:, self.order].T.ravel()).reshape(-1, 2).T
        return step


def _cholmod(rows: IntArray, columns: IntArray, n: int) -> Solver:
    """Solver by CHOLMOD for the lower triangle with these entries."""
    from cvxopt import cholmod, matrix, spmatrix

    A = spmatrix(1.0, matrix(rows), matrix(columns), (n, n))
    cholmod.options["supernodal"] = 2
    symbolic = cholmod.symbolic(A)

    def solve(values: FloatArray, b: FloatArray) -> FloatArray:
        A.V = matrix(values)
        x = matrix(b)
        try:
            cholmod.numeric(A, symbolic)
        except ArithmeticError as error:
            raise FactorisationFailed(f"CHOLMOD: not positive definite ({error})") from error
        cholmod.solve(symbolic, x)
        return np.asarray(x).ravel()

    return solve


def _superlu(rows: IntArray, columns: IntArray, n: int) -> Solver:
    """Solver by SuperLU in the order given."""
    below = np.flatnonzero(rows != columns)
    where = np.append(np.arange(len(rows)), below)
    A = sp.csc_matrix((where + 1.0, (np.append(rows, columns[below]), np.append(columns, rows[below]))), shape=(n, n))
    where = A.data.astype(np.int64) - 1

    def solve(values: FloatArray, b: FloatArray) -> FloatArray:
        A.data = values[where]
        try:
            lu = splu(A, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True, "Equil": False})
        except RuntimeError as error:
            raise FactorisationFailed(f"SuperLU: {error}") from error
        return np.asarray(lu.solve(b))

    return solve
