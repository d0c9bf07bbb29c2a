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
#: Entries (a, b) of a block, in the order in which they are numbered.
_PARTS = ((0, 1), (0, 0), (1, 0), (1, 1))


class VertexSystem:
    """Symmetric matrices of 2 x 2 blocks, one for each vertex and edge of a triangle mesh, which may have a boundary.

    Unknown a of vertex i is number 2 i + a. An edge's block has the rows of its larger vertex, and so lies in the lower
    triangle. Entries are numbered part by part, the entry (a, b) of all blocks; vertices' blocks come first. In these
    the first part, (0, 1), mirrors (1, 0): its n entries, numbered -n to -1, are left out.

    `limbs` says that the mesh may have narrow limbs, for the choice of an elimination order.
    """

    _analysis: Analysis | None = None

    def __init__(self, f: IntArray, n: int, backend: str = "auto", *, limbs: bool = False) -> None:
        self.f, self.n, self._backend, self._limbs = f, n, backend, limbs

    def assemble(self, blocks: FloatArray, at_vertices: FloatArray | None = None) -> FloatArray:
        """Entries of the sum of faces' blocks (6, 2, 2, m) for the corner pairs `PAIRS`, and vertices' (2, 2, n)."""
        values = np.bincount(self._targets, blocks.ravel())[self.n :]
        if at_vertices is not None:
            for a, b in _PARTS[1:]:
                values[self._of_vertices(a, b)] += at_vertices[a, b]
        return np.asarray(values, dtype=np.float64)

    def damped(
        self, values: FloatArray, share: float | FloatArray, added: float | FloatArray = 0.0
    ) -> FloatArray:
        """Entries with the diagonal raised by a share of itself and by `added`, each one number or one a vertex."""
        values = values.copy()
        for a in (0, 1):
            diagonal = self._of_vertices(a, a)
            values[diagonal] = (1 + share) * values[diagonal] + added
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
        """Larger and smaller vertex of each edge, and the edge opposite each corner (m, 3)."""
        keys, edge, *_ = shared_edges(self.f, self.n)
        return keys % self.n, keys // self.n, edge.reshape(-1, 3)

    def _first(self, a: int, b: int) -> int:
        """Number, plus n, of the entry (a, b) of the first vertex's block."""
        return _PARTS.index((a, b)) * (self.n + len(self._edges[0]))

    def _of_vertices(self, a: int, b: int) -> slice:
        """Numbers of the entries (a, b) of vertices' blocks."""
        return slice(self._first(a, b) - self.n, self._first(a, b))

    @cached_property
    def _targets(self) -> IntArray:
        """Number, plus n, of the entry to which each entry of the faces' blocks is added."""
        number = np.empty((6, 2, 2, len(self.f)), dtype=np.int64)
        for k, (i, j) in enumerate(PAIRS):
            block, mirrored = self.f[:, i], self.f[:, i] < self.f[:, j]
            if i != j:
                block = self.n + self._edges[2][:, 3 - i - j]
            for a, b in _PARTS:
                first = np.where(mirrored, self._first(b, a), self._first(a, b))
                np.add(first, block, out=number[k, a, b])
        return number.ravel()

    @cached_property
    def _entries(self) -> Entries:
        n, loops, (larger, smaller, _) = self.n, np.arange(self.n), self._edges
        rows, columns = np.append(loops, larger), np.append(loops, smaller)
        ends = np.append(rows, smaller), np.append(columns, larger)
        return Entries(
            sp.csr_matrix((np.ones(len(ends[0])), ends), shape=(n, n)),
            np.concatenate([2 * rows + a for a, _ in _PARTS])[n:],
            np.concatenate([2 * columns + b for _, b in _PARTS])[n:],
            unknowns=2,
            repeated=True,
            limbs=self._limbs,
        )


def gram_blocks(left: FloatArray, right: FloatArray) -> FloatArray:
    """Faces' blocks of the sum over rows of left^T right, both (rows, 3, 2, m), whose product is symmetric."""
    return np.stack([np.einsum("ram,rbm->abm", left[:, i], right[:, j]) for i, j in PAIRS])
