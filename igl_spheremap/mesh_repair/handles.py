"""Handles of a closed surface: short loops that do not separate it, one for each handle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import breadth_first_order, dijkstra, minimum_spanning_tree

from ..mesh.arrays import FloatArray, IntArray
from ..mesh.edges import edge_keys

#: Classes are counted modulo this prime: products stay within int64. A loop that does not separate the surface is taken
#: for one that does with a chance of 5e-10.
_PRIME = 2**31 - 1
#: Vertices of a loop of the basis at which searches for a first short loop begin: a handle along which the loop runs
#: for a 24th of its length has one of them. With 12 and 48 a torus, a kitten and an elephant of genus 3 are cut along
#: the same loops (tried by hand).
_ROOTS = 24
#: Reach of the first searches, in mean edge lengths; each further one reaches twice as far. With 3 and 12 the torus,
#: the kitten and the elephant are cut along the same loops (tried by hand).
_REACH = 6
#: Vertices, over all roots, that the exact searches near one loop may visit: those of a tenth of a second. Three roots
#: are searched from, however many vertices that visits. With half and twice the number the torus, the kitten and the
#: elephant are cut along the same loops (tried by hand).
_VISITS, _LEAST_ROOTS = 400_000, 3
#: A loop is shorter if the ratio of lengths is below this; above it the difference is rounding.
_SHORTER = 1 - 1e-9
#: A mean edge in the unit of lengths, which are whole numbers: their sums are exact, so that of loops that are equally
#: long the same one is taken whatever the units of the mesh, and paths of up to 2^17 such edges stay below 2^53.
_MEAN_EDGE = 2.0**36


def cutting_loops(v: FloatArray, f: IntArray) -> list[IntArray]:
    """Disjoint simple loops of vertices of a closed connected surface that together do not separate it.

    One for each handle, as a rule; at least one if there is a handle, and others once those are cut. The shortest come
    first: searches near the loops of a basis reach further and further, and end where a wider one finds no more.
    """
    loops = _Loops(v, f)
    basis, reach = loops.basis(), _REACH * _MEAN_EDGE
    while loops.uncut and basis:
        found = [loops.shortest(_evenly_spaced(loop, _ROOTS), reach) for loop in basis]
        for loop in sorted(
            (loops.tightened(loop) for loop in found if loop is not None), key=loops.length
        ):
            loops.cut(loop)  # unless it meets another one that was shorter
        without = [loop for loop, short in zip(basis, found, strict=True) if short is None]
        if loops.cuts and len(without) == len(basis):
            break
        basis, reach = without, 2 * reach
    return loops.cuts


def short_loop(v: FloatArray, f: IntArray) -> IntArray:
    """A loop of vertices that does not separate a closed surface with handles: the shortest near one of a basis."""
    loops = _Loops(v, f)
    return loops.tightened(min(loops.basis(), key=loops.length))


class _Loops:
    """The classes of loops of a closed surface, and the shortest loops near others.

    A tree of shortest paths, and a tree of the dual graph across the other edges, leave two edges for each handle (the
    tree-cotree decomposition, Erickson and Whittlesey 2005). Each closes a loop with the first tree, which together are
    a basis of the homology, and one with the second tree, a dual loop. How often a loop of vertices crosses each dual
    loop, with sign, is its homology class; it separates the surface if all are 0.
    """

    def __init__(self, v: FloatArray, f: IntArray) -> None:
        n = len(v)
        start, stop = f.ravel(), f[:, [1, 2, 0]].ravel()
        keys = edge_keys(start, stop, n)
        there, back = (
            half[np.argsort(keys[half])]
            for half in (np.flatnonzero(start < stop), np.flatnonzero(start > stop))
        )
        self._keys, self._n = keys[there], n
        self._tail, self._head = start[there], stop[there]
        length = np.linalg.norm(v[self._tail] - v[self._head], axis=1)
        # graphs know no length of 0
        self._length = np.rint(length * (_MEAN_EDGE / (length.mean() or 1.0))) + 1
        number = np.arange(len(there))
        rows, columns = np.append(self._tail, self._head), np.append(self._head, self._tail)
        entries = csr_matrix((np.append(number, number) + 1, (rows, columns)), shape=(n, n))
        self._edge = entries.data - 1
        self._sign = np.where(
            np.repeat(np.arange(n), np.diff(entries.indptr)) < entries.indices, 1, -1
        )
        self._graph = csr_matrix(
            (self._length[self._edge], entries.indices, entries.indptr), shape=(n, n)
        )
        entries.data = np.arange(1, len(self._edge) + 1)
        self._entries = entries
        distance, self._previous = dijkstra(self._graph, indices=0, return_predecessors=True)
        self._leftover, self._crossing = self._dual_loops(distance, there // 3, back // 3, len(f))
        rank = len(self._leftover)
        self._functionals = np.eye(rank, dtype=np.int64)  # of classes: 0 on the loops that were cut
        self._rng = np.random.default_rng(0)
        self._blocked = np.zeros(n, dtype=bool)
        self.cuts: list[IntArray] = []
        self._draw_functional()

    def _dual_loops(
        self, distance: FloatArray, left: IntArray, right: IntArray, m: int
    ) -> tuple[IntArray, csr_matrix]:
        """The edges in neither tree, and how often, with sign, each dual loop crosses each edge from left to right."""
        previous, tail, head = self._previous, self._tail, self._head
        free = np.flatnonzero((previous[tail] != head) & (previous[head] != tail))
        around = (distance[tail] + distance[head] + self._length)[free]
        # the tree takes those that close the longest loops
        free = free[np.argsort(-around, kind="stable")]
        pair = np.minimum(left, right)[free] * m + np.maximum(left, right)[free]
        _, first = np.unique(pair, return_index=True)  # two faces may share two edges
        pair, edge = pair[np.sort(first)], free[np.sort(first)]
        weights = np.arange(1, len(pair) + 1)
        dual = minimum_spanning_tree(
            csr_matrix((weights, (pair // m, pair % m)), shape=(m, m))
        ).tocoo()
        tree = edge[dual.data.astype(np.int64) - 1]
        leftover = np.setdiff1d(free, tree)
        links = coo_matrix((np.ones(len(tree)), (left[tree], right[tree])), shape=(m, m)).tocsr()
        _, parent = breadth_first_order(links, 0, directed=False, return_predecessors=True)
        up, sign = np.zeros(m, dtype=np.int64), np.zeros(m, dtype=np.int64)
        outward = parent[left[tree]] == right[tree]
        up[left[tree[outward]]], sign[left[tree[outward]]] = tree[outward], 1
        up[right[tree[~outward]]], sign[right[tree[~outward]]] = tree[~outward], -1
        rank = len(leftover)
        rows, columns, values = [leftover], [np.arange(rank)], [np.ones(rank, dtype=np.int64)]
        above = parent.tolist()
        for k, edge_left in enumerate(leftover.tolist()):
            for face, way in ((int(right[edge_left]), 1), (int(left[edge_left]), -1)):
                path = np.array(_to_root(above, face)[:-1], dtype=np.int64)
                rows.append(up[path])
                columns.append(np.full(len(path), k))
                values.append(way * sign[path])
        entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        return leftover, csr_matrix(entries, shape=(len(tail), rank))

    @property
    def uncut(self) -> int:
        """Handles that are not cut yet."""
        return len(self._leftover) // 2 - len(self.cuts)

    def basis(self) -> list[IntArray]:
        """The loops that the edges left by both trees close."""
        above = self._previous.tolist()
        found = []
        for edge in self._leftover.tolist():
            a, b = (_to_root(above, int(end[edge])) for end in (self._tail, self._head))
            found.append(np.array(_without_stem(a, b)))
        return found

    def length(self, loop: IntArray) -> float:
        """Length of a loop."""
        return float(self._length[self._edges(loop)].sum())

    def cut(self, loop: IntArray) -> None:
        """Cut along a loop, unless it meets an earlier cut or, with them, separates; later loops will keep off it."""
        if self._blocked[loop].any():
            return
        forward = np.where(loop < np.roll(loop, -1), 1, -1)
        values = self._functionals @ (self._crossing[self._edges(loop)].T @ forward) % _PRIME
        if not values.any():
            return
        k = int(np.flatnonzero(values)[0])
        ratio = values * pow(int(values[k]), -1, _PRIME) % _PRIME
        rest = self._functionals - ratio[:, None] * self._functionals[k] % _PRIME
        self._functionals = np.delete(rest, k, axis=0) % _PRIME
        self._blocked[loop] = True
        rows = np.repeat(self._blocked, np.diff(self._graph.indptr))
        self._graph.data[rows | self._blocked[self._graph.indices]] = np.inf
        self.cuts.append(loop)
        self._draw_functional()

    def tightened(self, loop: IntArray) -> IntArray:
        """A loop that does not separate, shortened until no shorter one runs through any of its vertices."""
        length = self.length(loop)
        while (shorter := self.shortest(loop, length / 2)) is not None:
            if not self.length(shorter) < _SHORTER * length:
                break
            loop, length = shorter, self.length(shorter)
        return loop

    def _draw_functional(self) -> None:
        """A random combination of the functionals that are left: 0 on loops that, with the cuts, separate."""
        mix = self._rng.integers(1, _PRIME, (len(self._functionals), 1))
        functional = (mix * self._functionals % _PRIME).sum(axis=0) % _PRIME
        self._values = self._sign * (self._crossing @ functional % _PRIME)[self._edge]

    def _edges(self, loop: IntArray) -> IntArray:
        return np.searchsorted(self._keys, edge_keys(loop, np.roll(loop, -1), self._n))

    def shortest(self, roots: IntArray, reach: float) -> IntArray | None:
        """The shortest loop that does not separate, through one of the roots and within `reach` of it, if any."""
        near = dijkstra(self._graph, indices=roots, limit=reach, min_only=True)
        ball = np.flatnonzero(np.isfinite(near))
        part = self._entries[ball][:, ball].tocoo()
        entry = part.data - 1
        weight = self._graph.data[entry]
        usable = np.isfinite(weight)
        if not usable.any():
            return None
        i, j, weight, value = (
            array[usable] for array in (part.row, part.col, weight, self._values[entry])
        )
        graph = csr_matrix((weight, (i, j)), shape=part.shape)
        roots = _evenly_spaced(
            np.searchsorted(ball, roots), max(_LEAST_ROOTS, _VISITS // max(1, len(ball)))
        )
        best, found = np.inf, None
        for root in roots.tolist():
            distance, previous = dijkstra(
                graph, indices=root, limit=reach, return_predecessors=True
            )
            potential = _potentials(previous, root, i, j, value)
            round_ = distance[i] + distance[j] + weight
            round_[(potential[i] + value - potential[j]) % _PRIME == 0] = np.inf
            k = int(round_.argmin())
            if round_[k] < best:
                best = float(round_[k])
                above = previous.tolist()
                found = ball[_without_stem(_to_root(above, int(i[k])), _to_root(above, int(j[k])))]
        return found


def _potentials(
    previous: NDArray[np.int32], root: int, i: IntArray, j: IntArray, value: IntArray
) -> IntArray:
    """Sums of the values of edges i -> j from the root to each vertex, along a tree; 0 where it does not reach."""
    step = np.zeros(len(previous), dtype=np.int64)
    branch = previous[j] == i
    step[j[branch]] = value[branch]
    jump = np.where(previous < 0, np.arange(len(previous)), previous)
    jump[root] = root
    while (jump[jump] != jump).any():  # each pass doubles the way that is summed
        step = (step + step[jump]) % _PRIME
        jump = jump[jump]
    return step


def _evenly_spaced(items: IntArray, most: int) -> IntArray:
    """At most that many of the items, evenly spaced."""
    return items[np.linspace(0, len(items), min(most, len(items)), endpoint=False).astype(np.int64)]


def _to_root(above: list[int], at: int) -> list[int]:
    """The vertices from one to the root of a tree, whose parent is negative."""
    path = [at]
    while (at := above[at]) >= 0:
        path.append(at)
    return path


def _without_stem(a: list[int], b: list[int]) -> list[int]:
    """The loop of two paths to a root and the edge between their first vertices, without what they share but one.

    >>> _without_stem([5, 3, 1, 0], [6, 4, 3, 1, 0])
    [3, 5, 6, 4]
    """
    while len(a) > 1 and len(b) > 1 and a[-2] == b[-2]:
        a, b = a[:-1], b[:-1]
    return a[::-1] + b[:-1]
