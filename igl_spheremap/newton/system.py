"""Linear systems with two unknowns a vertex, coupled within faces only: assembled, factorised, solved.

The same pattern serves all steps of a mesh. Only one triangle of a matrix is kept, as a list of its entries.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
import scipy.sparse as sp

from ..errors import FactorisationFailed
from ..mesh.arrays import FloatArray, IntArray
from ..mesh.edges import shared_edges
from ..operators.factor.factor import Analysis, Entries, Factor
from ..operators.factor.factorize import analyse
from ..operators.factor.memory import fits_memory

#: Corner pairs of a face whose 2 x 2 blocks are kept; the others are their transposes.
PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


class VertexSystem:
    """Symmetric matrices of 2 x 2 blocks, one for each vertex and edge of a triangle mesh, which may have a boundary.

    Unknown a of vertex i is number 2 i + a. `limbs` says that the mesh may have narrow limbs, for the choice of an
    elimination order.
    """

    _analysis: Analysis | None = None

    def __init__(self, f: IntArray, n: int, backend: str = "auto", *, limbs: bool = False) -> None:
        self.f, self.n, self._backend, self._limbs = f, n, backend, limbs

    def assemble(self, blocks: FloatArray, at_vertices: FloatArray | None = None) -> FloatArray:
        """Entries of the sum of faces' blocks (6, 2, 2, m) for the corner pairs `PAIRS`, and vertices' (2, 2, n)."""
        values = np.asarray(
            np.bincount(self._numbers, blocks.ravel())[:-1],
            dtype=np.float64,
        )
        if at_vertices is not None:
            for (a, b), numbers in zip(((0, 0), (1, 0), (1, 1)), self._at_vertices, strict=True):
                values[numbers] += at_vertices[a, b]
        return values

    def damped(
        self, values: FloatArray, share: float | FloatArray, added: float | FloatArray = 0.0
    ) -> FloatArray:
        """Entries with the diagonal raised by a share of itself and by `added`, each one number or one a vertex."""
        values = values.copy()
        for numbers in self._at_vertices[::2]:
            values[numbers] = (1 + share) * values[numbers] + added
        return values

    def factorize(self, values: FloatArray, within_memory: bool = False) -> Factor:
        """Exact factor of a matrix, in place of the one before, or FactorisationFailed.

        If `within_memory`, it takes at most half of the machine's.
        """
        if within_memory and not fits_memory(2 * self.n):
            raise FactorisationFailed("two unknowns a vertex: too large for an exact factorisation")
        if self._analysis is None:
            self._analysis = analyse(self._entries, self._backend)
        return self._analysis.factorize(values)

    def solve(self, factor: Factor, load: FloatArray) -> FloatArray:
        """Solutions of systems with the right-hand sides (..., 2, n)."""
        columns = np.ascontiguousarray(load.reshape(-1, 2, self.n).transpose(2, 1, 0)).reshape(
            2 * self.n, -1
        )
        if load.ndim == 2:
            columns = columns[:, 0]
        solved = factor.solve(columns)
        return np.ascontiguousarray(solved.reshape(self.n, 2, -1).transpose(2, 1, 0)).reshape(
            load.shape
        )

    def gathered(self, parts: FloatArray) -> FloatArray:
        """Sums (2, n) at the vertices of faces' parts at their corners, (2, 3, m)."""
        corners = self.f.T.ravel()
        return np.stack([np.bincount(corners, part.ravel(), self.n) for part in parts])

    @cached_property
    def _edges(self) -> tuple[IntArray, IntArray, IntArray]:
        """Larger and smaller vertex of each edge, and the edge between the corners of each off-diagonal pair."""
        keys, edge, *_ = shared_edges(self.f, self.n)
        return keys % self.n, keys // self.n, edge.reshape(-1, 3).T[::-1]

    @cached_property
    def _layout(self) -> tuple[IntArray, IntArray, IntArray]:
        """Rows and columns of the entries; and for each (a, b) the offset from a block's number to its entry (a, b).

        Vertices' blocks come before edges'. The entries (0, 0) of all blocks come first, then (0, 1), (1, 0) and (1,
        1). Vertices' blocks lack (0, 1), as it mirrors (1, 0).
        """
        n, (larger, smaller, _) = self.n, self._edges
        loops, blocks = np.arange(n), n + len(larger)
        rows, columns = 2 * np.concatenate((loops, larger)), 2 * np.concatenate((loops, smaller))
        return (
            np.concatenate((rows, rows[n:], rows + 1, rows + 1)),
            np.concatenate((columns, columns[n:] + 1, columns, columns + 1)),
            np.array([[0, blocks - n], [2 * blocks - n, 3 * blocks - n]]),
        )

    @cached_property
    def _at_vertices(self) -> IntArray:
        """Numbers of the entries (0, 0), (1, 0) and (1, 1) of each vertex's block."""
        return self._layout[2].ravel()[[0, 2, 3], None] + np.arange(self.n)

    @cached_property
    def _numbers(self) -> IntArray:
        """Number of the entry to which each entry of the faces' blocks is added; one past the last if to none."""
        edge, (rows, _, first) = iter(self.n + self._edges[2]), self._layout
        found = np.empty((6, 2, 2, len(self.f)), dtype=np.int64)
        for k, (i, j) in enumerate(PAIRS):
            if i == j:
                np.add(first[:, :, None], self.f[:, i], out=found[k])
                found[k, 0, 1] = len(rows)
            else:
                mirrored = self.f[:, i] < self.f[:, j]
                np.add(
                    np.where(mirrored, first.T[:, :, None], first[:, :, None]),
                    next(edge),
                    out=found[k],
                )
        return found.ravel()

    @cached_property
    def _entries(self) -> Entries:
        rows, columns, _ = self._layout
        loops, (larger, smaller, _) = np.arange(self.n), self._edges
        ends = np.concatenate((loops, larger, smaller)), np.concatenate((loops, smaller, larger))
        graph = sp.csr_matrix((np.ones(len(ends[0])), ends), shape=(self.n, self.n))
        return Entries(graph, rows, columns, unknowns=2, repeated=True, limbs=self._limbs)


def gram_blocks(left: FloatArray, right: FloatArray) -> FloatArray:
    """Faces' blocks of the sum over rows of left^T right, both (rows, 3, 2, m), whose product is symmetric."""
    return np.stack([np.einsum("ram,rbm->abm", left[:, i], right[:, j]) for i, j in PAIRS])
