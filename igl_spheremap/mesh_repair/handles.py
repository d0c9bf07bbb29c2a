"""Handles of a closed surface: short loops that do not separate it, one for each handle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import breadth_first_order, dijkstra, minimum_spanning_tree

from ..mesh.arrays import FloatArray, IntArray
from ..mesh.edges import components, edge_keys, marked, shared_edges, sides

#: A mean edge in the unit of lengths, which are whole numbers: their sums are exact, so the choice among equally long
#: loops does not depend on the mesh's units. Paths of up to 2^17 such edges stay below 2^53.
_MEAN_EDGE = 2.0**36


def cutting_loops(v: FloatArray, f: IntArray, reach: float = 6.0) -> list[IntArray]:
    """Disjoint simple loops of vertices of a closed connected surface that together do not separate it.

    If there is a handle, at least one; others once those are cut. Searches at the loops of a basis reach that many mean
    edge lengths, then twice as far until one is found.
    """
    loops = _Loops(v, f)
    if not loops.basis:
        return []
    while not (found := loops.near_basis(reach * _MEAN_EDGE)):
        reach *= 2
    taken: dict[int, IntArray] = {}  # by values: two loops of one value separate
    blocked = np.zeros(len(v), dtype=bool)
    for loop in sorted(found, key=loops.length):
        if blocked[loop].any() or loops.value(loop) in taken:
            continue
        short = loops.tightened(loop)
        if not blocked[short].any():
            blocked[short] = True
            taken.setdefault(loops.value(short), short)
    return loops.not_separating(list(taken.values()))


def short_loop(v: FloatArray, f: IntArray) -> IntArray:
    """A loop of vertices that does not separate a closed surface with handles: the shortest near one of a basis."""
    loops = _Loops(v, f)
    return loops.tightened(min(loops.basis, key=loops.length))


class _Loops:
    """Loops of a closed surface that do not separate it.

    A tree of shortest paths, and a tree of the dual graph across the other edges, leave two edges for each handle (the
    tree-cotree decomposition, Erickson and Whittlesey 2005). Each closes a loop with the first tree, which together are
    a basis of the homology, and one with the second tree, a dual loop. A loop of vertices separates the surface if it
    crosses each dual loop as often one way as the other. Each dual loop has a random value, and an edge the sum of
    those that cross it, with sign: around a loop that separates the edges' values sum to 0.
    """

    def __init__(self, v: FloatArray, f: IntArray) -> None:
        n = len(v)
        self._n, (start, stop) = n, sides(f)
        self._keys, _, first, second = shared_edges(f, n)
        up = start[first] < stop[first]
        there, back = np.where(up, first, second), np.where(up, second, first)
        self._tail, self._head = start[there], stop[there]
        self._left, self._right = there // 3, back // 3
        length = np.linalg.norm(v[self._tail] - v[self._head], axis=1)
        # graphs know no length of 0
        if length.any():
            length *= _MEAN_EDGE / length.mean()
        self._length = np.rint(length) + 1
        number = np.arange(len(there))
        rows, columns = np.append(self._tail, self._head), np.append(self._head, self._tail)
        self._edges = csr_matrix((np.append(number, number) + 1, (rows, columns)), shape=(n, n))
        self._graph = self._edges.astype(np.float64)
        self._graph.data = self._length[self._edges.data - 1]
        distance, previous = dijkstra(self._graph, indices=0, return_predecessors=True)
        leftover, self._values = self._dual_loops(distance, previous, len(f))
        above = previous.tolist()
        self.basis = [
            np.array(_without_stem(_to_root(above, a), _to_root(above, b)))
            for a, b in zip(
                self._tail[leftover].tolist(), self._head[leftover].tolist(), strict=True
            )
        ]

    def _dual_loops(
        self, distance: FloatArray, previous: NDArray[np.int32], m: int
    ) -> tuple[IntArray, IntArray]:
        """The edges in neither tree, and the values of all edges, crossed from left to right."""
        tail, head, left, right = self._tail, self._head, self._left, self._right
        free = np.flatnonzero((previous[tail] != head) & (previous[head] != tail))
        around = (distance[tail] + distance[head] + self._length)[free]
        # the tree takes those that close the longest loops
        free = free[np.argsort(-around, kind="stable")]
        pair = np.minimum(left, right)[free] * m + np.maximum(left, right)[free]
        _, first = np.unique(pair, return_index=True)  # two faces may share two edges
        pair, edge = pair[np.sort(first)], free[np.sort(first)]
        weights = np.arange(1, len(pair) + 1)
        dual_edges = csr_matrix((weights, (pair // m, pair % m)), shape=(m, m))
        dual = minimum_spanning_tree(dual_edges).tocoo()
        tree = edge[dual.data.astype(np.int64) - 1]
        leftover = np.setdiff1d(free, tree)
        links = coo_matrix((np.ones(len(tree)), (left[tree], right[tree])), shape=(m, m)).tocsr()
        order, parent = breadth_first_order(links, 0, directed=False, return_predecessors=True)
        values = np.zeros(len(tail), dtype=np.int64)
        # Sums along paths stay within int64; a loop is taken for one that separates with a chance of 5e-10.
        values[leftover] = np.random.default_rng(0).integers(1, 2**31, len(leftover))
        ends = np.zeros(
            m, dtype=np.int64
        )  # of dual loops in faces: they run up the tree from there
        np.add.at(ends, right[leftover], values[leftover])
        np.subtract.at(ends, left[leftover], values[leftover])
        below, above = ends.tolist(), parent.tolist()
        for face in order[:0:-1].tolist():
            below[above[face]] += below[face]
        sums = np.array(below)
        values[tree] = np.where(
            parent[left[tree]] == right[tree], sums[left[tree]], -sums[right[tree]]
        )
        return leftover, values

    def length(self, loop: IntArray) -> float:
        """Length of a loop."""
        return float(self._length[self._numbers(loop)].sum())

    def value(self, loop: IntArray) -> int:
        """Sum of a loop's values, without sign: two loops of one sum separate the surface together."""
        value = self._values[self._numbers(loop)]
        return abs(int(np.where(loop < np.roll(loop, -1), value, -value).sum()))

    def _numbers(self, loop: IntArray) -> IntArray:
        return np.searchsorted(self._keys, edge_keys(loop, np.roll(loop, -1), self._n))

    def near_basis(self, reach: float, roots: int = 24) -> list[IntArray]:
        """The shortest loops that don't separate, within `reach` of some equally spaced vertices of each basis loop.

        A search from a distance d to a loop of length l finds one at most 2 d longer: none begins near an earlier one.
        """
        found: dict[bytes, IntArray] = {}
        covered = np.zeros(self._n, dtype=bool)
        begin = [_evenly_spaced(loop, roots) for loop in self.basis]
        for root in np.unique(np.concatenate(begin)).tolist():
            if covered[root]:
                continue
            distance, previous = dijkstra(
                self._graph, indices=root, limit=reach, return_predecessors=True
            )
            covered |= distance <= reach / 8
            loop = self._closed(distance, previous)
            if loop is not None:
                found[np.sort(loop).tobytes()] = loop
        return list(found.values())

    def tightened(
        self, loop: IntArray, visits: int = 400_000, shorter_by: float = 1e-9
    ) -> IntArray:
        """A loop that does not separate, shortened until no shorter one runs through any of its vertices.

        Searches begin at three of these, and at more if all together visit at most `visits` vertices, some .1 s.
        """
        while True:
            length = self.length(loop)
            near = dijkstra(self._graph, indices=loop, limit=length / 2, min_only=True)
            most = max(3, visits // int(np.isfinite(near).sum()))
            best, shorter = (1 - shorter_by) * length, None
            for root in _evenly_spaced(loop, most).tolist():
                other = self._closed(
                    *dijkstra(self._graph, indices=root, limit=best / 2, return_predecessors=True)
                )
                if other is not None and self.length(other) < best:
                    best, shorter = self.length(other), other
            if shorter is None:
                return loop
            loop = shorter

    def _closed(self, distance: FloatArray, previous: NDArray[np.int32]) -> IntArray | None:
        """The shortest loop that does not separate, of two shortest paths from a root and an edge, if there is one."""
        ball = np.flatnonzero(np.isfinite(distance))
        part = self._edges[ball].tocoo()
        inside = np.isfinite(distance[part.col])
        i, j = part.row[inside], np.searchsorted(ball, part.col[inside])
        edge = part.data[inside] - 1
        distance, before = distance[ball], np.searchsorted(ball, previous[ball])
        at_root = distance == 0
        value = np.where(ball[i] < ball[j], self._values[edge], -self._values[edge])
        potential = _potentials(np.where(at_root, np.arange(len(ball)), before), i, j, value)
        around = distance[i] + distance[j] + self._length[edge]
        around[potential[i] + value == potential[j]] = np.inf
        if not np.isfinite(around).any():
            return None
        k = int(around.argmin())
        above = np.where(at_root, -1, before).tolist()
        return ball[_without_stem(_to_root(above, int(i[k])), _to_root(above, int(j[k])))]

    def not_separating(self, loops: list[IntArray]) -> list[IntArray]:
        """Disjoint loops that together do not separate the surface: the longest are left out."""
        edges = [self._numbers(loop) for loop in loops]
        kept = ~marked(np.concatenate(edges), len(self._keys))
        m = len(self._left) * 2 // 3
        _, piece = components(self._left[kept], self._right[kept], m)
        joined = np.arange(len(piece))
        cut = []
        for loop, edge in zip(loops[::-1], edges[::-1], strict=True):
            a, b = joined[piece[[self._left[edge[0]], self._right[edge[0]]]]]
            if a == b:
                cut.append(loop)
            joined[joined == b] = a
        return cut[::-1]


def _potentials(above: IntArray, i: IntArray, j: IntArray, value: IntArray) -> IntArray:
    """Sums of the values of edges i -> j from the root of a tree, which is above itself, to each vertex."""
    step = np.zeros(len(above), dtype=np.int64)
    branch = (above[j] == i) & (above[j] != j)
    step[j[branch]] = value[branch]
    while (above[above] != above).any():  # each pass doubles the way that is summed
        step = step + step[above]
        above = above[above]
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
    """The loop of two paths to a root and the edge between their first vertices, without their common vertices but one.

    >>> _without_stem([5, 3, 1, 0], [6, 4, 3, 1, 0])
    [3, 5, 6, 4]
    """
    while len(a) > 1 and len(b) > 1 and a[-2] == b[-2]:
        a, b = a[:-1], b[:-1]
    return a[::-1] + b[:-1]
