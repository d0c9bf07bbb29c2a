"""Normal equations of two unknowns a vertex that only meet within faces: one assembly for angles and for positions."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from ..errors import FactorisationFailed
from ..mesh.arrays import FloatArray, IntArray
from ..operators.factor.conjugate_gradients import block_jacobi
from ..operators.factor.factor import Analysis, Entries, Factor
from ..operators.factor.factorize import analyse, fits_memory, refactorize


class VertexBlocks:
    """Matrices of 2 x 2 blocks, one for each vertex and each half-edge of a closed mesh; analysed once."""

    _analysis: Analysis | None = None

    def __init__(self, f: IntArray) -> None:
        self.f, self.n = f, len(f) // 2 + 2

    def factorize(self, H: sp.csr_matrix, damping: float | FloatArray, added: float | FloatArray,
                  exact: bool = True) -> Factor:
        """Factorise a matrix of `gram` whose diagonal is raised by the share `damping` of itself and by `added`."""
        H = H.copy()
        H.setdiag((1 + damping) * H.diagonal() + added)
        if not exact:
            return block_jacobi(H)
        if not fits_memory(H.shape[0]):
            raise FactorisationFailed("two unknowns a vertex: too large for an exact factorisation")
        if self._analysis is None:
            self._analysis = analyse(replace(Entries.of(H), repeated=True, limbs=True))
        return refactorize(self._analysis, H.data)

    def gram(self, left: FloatArray, right: FloatArray) -> sp.csr_matrix:
        """Sum over faces of left^T right, where both are (rows, 6, m) and the product is symmetric.

        Entry 2 k + a of the middle axis belongs to unknown a of corner k.
        """
        n, m = self.n, len(self.f)

        def block(i: int, j: int) -> FloatArray:
            return np.stack([(left[:, 2 * i + a] * right[:, 2 * j + b]).sum(axis=0)
                             for a in range(2) for b in range(2)])

        diagonal = np.zeros((4, n))
        half = np.empty((4, 3 * m))
        for k in range(3):
            for row, values in zip(diagonal, block(k, k), strict=True):
                row += np.bincount(self.f[:, k], values, n)
            half[:, k * m:(k + 1) * m] = block(k, (k + 1) % 3)
        opposite, where = self._half_edges
        pairs = half + half[[0, 2, 1, 3]].take(opposite, axis=1)  # the block of (j, i) is that of (i, j), transposed
        data = np.concatenate((diagonal, pairs), axis=1).T.take(where.data, axis=0)
        return sp.bsr_matrix((data.reshape(-1, 2, 2), where.indices, where.indptr), shape=(2 * n, 2 * n)).tocsr()

    def load(self, rows: FloatArray) -> FloatArray:
        """Sums (n, 2) at the vertices of what each face adds to its corners, (6, m)."""
        parts = rows.reshape(3, 2, -1).transpose(1, 0, 2)
        return np.column_stack([np.bincount(self.f.T.ravel(), part.ravel(), self.n) for part in parts])

    @cached_property
    def _half_edges(self) -> tuple[IntArray, sp.csr_matrix]:
        """The opposite of each half-edge, and a matrix's pattern, whose data number the vertices, then half-edges."""
        n, start, end = self.n, self.f.T.ravel(), self.f.T[[1, 2, 0]].ravel()
        ids = np.arange(1, len(start) + 1)
        order = sp.csr_matrix((ids, (start, end)), shape=(n, n))
        order.sort_indices()
        opposite = np.empty_like(start)
        opposite[order.data - 1] = order.T.tocsr().data - 1
        loop = np.arange(n)
        pattern = sp.csr_matrix((np.append(loop, n + ids - 1), (np.append(loop, start), np.append(loop, end))),
                                shape=(n, n))
        pattern.sort_indices()
        return opposite, pattern
