"""Positions in the plane from closed angles, by sums along the shortest edges, relative to any vertex.

Between two neighbours the tree of shortest edges uses no edge longer than theirs. So positions relative to a tip are
precise relative to the distance from it, however small that is: the deepest limbs keep their shape.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

from ..mesh.arrays import ComplexArray, FloatArray, IntArray
from ..operators.flips import twins


class Layout:
    """A triangulated sphere without one face, laid out in the plane by its angles.

    Attributes
    ----------
    f, hole
        The faces, and the one that is cut out.
    log_edge : (n,) float64 array
        Mean logarithm of the lengths of the edges around each vertex, in any unit.
    """

    def __init__(self, f: IntArray, angles: FloatArray, hole: int) -> None:
        self.f, self.hole, self.n = f, hole, len(f) // 2 + 2
        log_length, direction = lengths_and_directions(f, angles, hole)
        kept = np.repeat(np.arange(len(f)) != hole, 3)
        start, end = f[:, [1, 2, 0]].ravel()[kept], f[:, [2, 0, 1]].ravel()[kept]
        length, turn = log_length.ravel()[kept], direction.ravel()[kept]
        self.log_edge = np.bincount(start, length, self.n) / np.bincount(start, minlength=self.n)
        key = np.append(start * self.n + end, end * self.n + start)
        order = np.argsort(key, kind="stable")
        self._key = key[order]
        self._log_length, self._direction = np.append(length, length)[order], np.append(turn, turn + np.pi)[order]
        graph = sp.csr_matrix((length - length.min() + 1, (start, end)), shape=(self.n, self.n))
        tree = minimum_spanning_tree(graph.maximum(graph.T))
        self._tree = (tree + tree.T).tocsr()

    def path(self, root: int) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
        """Vertices but the root, breadth first; the parent of each in the tree; log length and direction from there."""
        order, parent = breadth_first_order(self._tree, root, directed=False)
        child = order[1:].astype(np.int64)
        above = parent[child].astype(np.int64)
        at = np.searchsorted(self._key, above * self.n + child)
        return child, above, self._log_length[at], self._direction[at]

    def about(self, root: int, log_unit: float) -> ComplexArray:
        """Positions relative to a vertex, in units of exp(log_unit)."""
        child, above, length, turn = self.path(root)
        largest = np.log(np.finfo(float).max) - 9  # so that sums of thousands of edges are finite
        edge = np.exp(np.clip(length - log_unit, -largest, largest) + 1j * turn)
        z = [0j] * self.n
        for c, a, e in zip(child.tolist(), above.tolist(), edge.tolist(), strict=True):
            z[c] = z[a] + e
        return np.array(z)


class Inverted(Layout):
    """A layout after the inversion that takes the middle of a face to infinity, as precise as the layout."""

    def __init__(self, layout: Layout, face: int) -> None:
        self.f, self._layout = layout.f, layout
        corner = int(self.f[face, 0])
        self._unit = float(layout.log_edge[corner])
        z = layout.about(corner, self._unit)
        self._z = z - z[self.f[face]].mean()
        self.log_edge = layout.log_edge - self._unit - 2 * np.log(np.abs(self._z))

    def about(self, root: int, log_unit: float) -> ComplexArray:
        """Positions relative to a vertex, in units of exp(log_unit)."""
        z = self._layout.about(root, self._unit) / self._z / self._z[root]  # their product may overflow
        return -z * np.exp(-log_unit)


def lengths_and_directions(f: IntArray, angles: FloatArray, hole: int) -> tuple[FloatArray, FloatArray]:
    """Log length and direction of each half-edge, (m, 3): column k runs from corner k + 1 to k + 2.

    Faces take the length and the direction of an edge from a neighbour that has them, outwards from one beside the
    hole. The hole's own row is NaN.
    """
    m = len(f)
    sines = np.log(np.sin(angles))
    turn = np.column_stack((np.zeros(m), np.pi - angles[:, 2], 2 * np.pi - angles[:, 2] - angles[:, 0]))
    twin = twins(f)
    scale, rotation = np.full(m, np.nan), np.zeros(m)
    front = twin[3 * hole:3 * hole + 1] // 3
    done = np.zeros(m, dtype=bool)
    scale[front], done[front], done[hole] = 0.0, True, True
    while len(front):
        half = (3 * front[:, None] + np.arange(3)).ravel()
        other = twin[half]
        new = ~done[other // 3]
        front, first = np.unique(other[new] // 3, return_index=True)
        half, other = half[new][first], other[new][first]
        scale[front] = scale[half // 3] + sines.flat[half] - sines.flat[other]
        rotation[front] = rotation[half // 3] + turn.flat[half] + np.pi - turn.flat[other]
        done[front] = True
    return scale[:, None] + sines, rotation[:, None] + turn
