"""Half-edge collapses of independent sets of vertices, which can be undone in reverse order.

A collapse v -> t removes the two faces that hold both and hands the other faces of v to t. It keeps a
triangulated sphere one if v and t have exactly two common neighbours (the link condition). Every vertex of a
triangulated sphere with more than four has such a neighbour: the edges outside the star that join vertices of
its link are non-crossing chords of a polygon, so two of the link's vertices meet none. Hence any set of
vertices can be removed, down to a tetrahedron.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..mesh.arrays import BoolArray, FloatArray, IntArray
from ..mesh.edges import marked, touching
from ..sphere.rows import binary_sizes, row_dets, row_dots
from ..verify.certificate import Certificate
from ..verify.signs import folded_faces
from .kernel import Stars, stars_of

#: Rounds unit rows to positions that vertices may take.
Grid = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True)
class Batch:
    """Vertices that were removed together; no two of them were neighbours.

    Attributes
    ----------
    stars : Stars
        Their stars before the removal.
    target : (k,) int64 array
        The neighbour that each was collapsed to.
    """

    stars: Stars
    target: IntArray


class ProgressiveMesh:
    """A triangulated sphere, or a part of one, with half-edge collapses that can be undone (Hoppe 1996).

    Attributes
    ----------
    f : (m, 3) int64 array
        Faces; rows that are not `alive` are stale.
    alive : (m,) bool array
        Faces of the present mesh.
    present : (n,) bool array
        Vertices of the present mesh.
    """

    def __init__(self, f: IntArray, x: FloatArray, frozen: BoolArray, grid: Grid) -> None:
        self.f, self.x, self.frozen, self.grid = f.copy(), x, frozen, grid
        self.alive = np.ones(len(f), dtype=bool)
        self.present = np.zeros(len(x), dtype=bool)
        self.present[f.ravel()] = True
        self.bad = folded_faces(x, f)

    def is_bijective(self) -> bool:
        """True if the present mesh covers the sphere once and without folding."""
        return Certificate.of(self.x, self.f[self.alive]).folding_free

    def faces(self) -> IntArray:
        """Indices of the faces that are alive."""
        return np.flatnonzero(self.alive)

    def collapse(self, batch: Batch) -> None:
        """Remove a batch of vertices."""
        stars, target = batch.stars, batch.target[batch.stars.owner]
        gone = (stars.a == target) | (stars.b == target)
        self.alive[stars.faces[gone]] = self.bad[stars.faces[gone]] = False
        kept = stars.faces[~gone]
        self.f[kept] = np.stack((target, stars.a, stars.b), axis=1)[~gone]
        self.bad[kept] = folded_faces(self.x, self.f[kept])
        self.present[stars.vertices] = False

    def restore(self, batch: Batch) -> None:
        """Put a batch of vertices back; the caller sets their positions."""
        stars = batch.stars
        self.f[stars.faces] = np.stack((stars.vertices[stars.owner], stars.a, stars.b), axis=1)
        self.alive[stars.faces] = True
        self.present[stars.vertices] = True

    def next_batch(self, wanted: BoolArray) -> Batch | None:
        """Choose an independent set among the wanted vertices, and their targets."""
        ids = self.faces()
        spare = len(self.x)
        if not self.frozen.any():  # a tetrahedron is left
            spare = int(self.present.sum()) - 4
        wanted = wanted & self.present
        if spare <= 0 or not wanted.any():
            return None
        f = self.f[ids]
        stars = stars_of(f, wanted, ids)
        stars = stars.take(independent(stars, len(self.x)))
        near = marked(np.append(stars.vertices, stars.a), len(self.x))
        adjacency = _Adjacency(f[touching(f, near)], len(self.x))
        target = self._best_targets(stars, adjacency)
        rows = np.flatnonzero(target >= 0)
        rows = rows[_edges_new_once(stars.take(rows), target[rows], len(self.x))][:spare]
        if not len(rows):
            return None
        return Batch(stars.take(rows), target[rows])

    def _best_targets(self, stars: Stars, adjacency: _Adjacency) -> IntArray:
        """The target of each star's centre: the neighbour whose fan folds least, then is best shaped; or -1."""
        owner = stars.owner  # each neighbour of a vertex is the `a` of exactly one outer edge
        contractible = adjacency.common(stars.vertices[owner], stars.a) == 2
        pairs = np.flatnonzero(contractible & ~self.frozen[stars.a])
        pairs = pairs[_spread(owner[pairs], stars.valence)]
        owner = owner[pairs]
        cost = self._fan_cost(stars, owner, stars.a[pairs])
        # hubs last, so chains halve evenly
        order = np.lexsort((adjacency.degree[stars.a[pairs]], cost, owner))
        owner, first = np.unique(owner[order], return_index=True)
        target = np.full(len(stars.vertices), -1)
        target[owner] = stars.a[pairs[order[first]]]
        return target

    def _fan_cost(self, stars: Stars, owner: IntArray, target: IntArray) -> FloatArray:
        """Number of foldings in the fan from each target, plus a penalty of up to 1/2 for its worst shaped face."""
        fans = stars.take(owner)
        pair = fans.owner
        t = target[pair]
        inside = np.flatnonzero((fans.a != t) & (fans.b != t))
        p, a, b = self.x[t[inside]], self.x[fans.a[inside]], self.x[fans.b[inside]]
        u, w = a - p, b - p
        # without it products underflow near ends of axes
        size = binary_sizes(np.abs(u) + np.abs(w))[:, None]
        u, w = u / size, w / size
        det = row_dets(p, u, w)
        sides = row_dots(u, u) + row_dots(w, w) + row_dots(w - u, w - u)
        # With 2 sqrt 3 = 3.46 equilateral faces would have 1; a little less stays below 1 in spite of rounding.
        quality = 3.4 * np.divide(det, sides, out=np.zeros(len(det)), where=sides > 0)
        worst, foldings = np.full(len(target), 1.0), np.zeros(len(target))
        np.minimum.at(worst, pair[inside], quality)
        np.add.at(foldings, pair[inside], quality <= 0)
        return foldings + (1 - np.clip(worst, 0.0, 1.0)) / 2


class _Adjacency:
    """Neighbour lists and edge look-up of a set of faces."""

    def __init__(self, f: IntArray, n: int) -> None:
        u, w = f[:, [0, 1, 2]].ravel(), f[:, [1, 2, 0]].ravel()
        both = np.concatenate((u * n + w, w * n + u))
        both.sort()
        self.n = n
        self.keys = both[np.flatnonzero(np.diff(both, prepend=-1))]
        self.degree = np.bincount(self.keys // n, minlength=n)
        self.start = np.cumsum(self.degree) - self.degree

    def common(self, u: IntArray, w: IntArray) -> IntArray:
        """Number of common neighbours of each pair, by running through the shorter list."""
        swap = self.degree[u] > self.degree[w]
        short, other = np.where(swap, w, u), np.where(swap, u, w)
        count = self.degree[short]
        begin = np.cumsum(count) - count
        owner = np.repeat(np.arange(len(u)), count)
        q = self.keys[np.arange(count.sum()) + np.repeat(self.start[short] - begin, count)] % self.n
        wanted = other[owner] * self.n + q
        at = np.minimum(np.searchsorted(self.keys, wanted), len(self.keys) - 1)
        return np.bincount(owner[self.keys[at] == wanted], minlength=len(u))


def independent(stars: Stars, n: int) -> IntArray:
    """Rows of stars whose centres come before all their neighbours in the order of valence, then of a fixed shuffle."""
    rank = _ranked(stars, stars.valence, n)
    return np.flatnonzero(rank[stars.vertices] < np.minimum.reduceat(rank[stars.a], stars.start))


def colour_classes(stars: Stars, n: int) -> list[IntArray]:
    """Rows of stars among n vertices, in classes within which no centres are neighbours: 5 or 6 of most meshes.

    Each star takes the first class that none of its neighbours has, after all neighbours of higher valence (Jones and
    Plassmann 1993, *A Parallel Graph Coloring Heuristic*).
    """
    # one bit; 0 for none yet
    rank, colour = _ranked(stars, -stars.valence, n), np.zeros(n, dtype=np.int64)
    while (first := rank[stars.vertices] < np.minimum.reduceat(rank[stars.a], stars.start)).any():
        taken = np.bitwise_or.reduceat(colour[stars.a], stars.start)[first]
        chosen = stars.vertices[first]
        colour[chosen], rank[chosen] = ~taken & (taken + 1), np.iinfo(np.int64).max
    own = colour[stars.vertices]
    return [np.flatnonzero(own == each) for each in np.unique(own)]


def _ranked(stars: Stars, first: IntArray, n: int) -> IntArray:
    """Ranks of n vertices: centres by the small integers `first`, then by a fixed shuffle; all others come last."""
    shuffled = (stars.vertices * 2654435761) % 4294967291  # a permutation: the modulus is prime
    rank = np.full(n, np.iinfo(np.int64).max)
    rank[stars.vertices] = first * 4294967296 + shuffled
    return rank


def _spread(owner: IntArray, valence: IntArray, faces: int = 512) -> BoolArray:
    """Neighbours, among those that meet the link condition, to try as targets: all, or at high valence every k-th.

    The fans that are tried for a vertex have at most this many faces together, so that the collapse of a hub costs no
    more than in proportion to its valence. Up to a valence of 22 all are tried.
    """
    stride = -(-(valence**2) // faces)
    first = np.searchsorted(owner, np.arange(len(valence)))
    return (np.arange(len(owner)) - first[owner]) % stride[owner] == 0


def _edges_new_once(stars: Stars, target: IntArray, n: int) -> BoolArray:
    """False for collapses that would add an edge of an earlier row's collapse."""
    t = target[stars.owner]
    # the edge to `a` is new unless `a` is the target or one of the two neighbours of v and t
    after, before = stars.b[stars.a == t], stars.a[stars.b == t]
    beside = (stars.a == t) | (stars.a == after[stars.owner]) | (stars.a == before[stars.owner])
    new = np.flatnonzero(~beside)
    key = np.minimum(t, stars.a)[new] * n + np.maximum(t, stars.a)[new]
    order = np.argsort(key, kind="stable")
    repeated = np.flatnonzero(np.diff(key[order], prepend=-1) == 0)
    keep = np.ones(len(stars.vertices), dtype=bool)
    keep[stars.owner[new[order[repeated]]]] = False
    return keep
