"""Polygons cut into triangles that keep their shape, in any plane: fans where these are right, ears elsewhere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..mesh.arrays import (
    BoolArray,
    FloatArray,
    IntArray,
    check_triangles,
    is_padded,
    own_unit,
    plain_array,
    plural,
)
from ..mesh.edges import edge_keys
from . import SIX_DIGITS


def triangulated(v: FloatArray, f: ArrayLike) -> tuple[IntArray, IntArray, tuple[str, ...]]:
    """Faces as triangles, the row of `f` that each comes from, and what was done: arrays of polygons are cut.

    >>> v = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    >>> faces, row, done = triangulated(v, [[0, 1, 2, 3]])
    >>> faces.tolist(), row.tolist(), done
    ([[0, 1, 2], [0, 2, 3]], [0, 0], ('triangulated 1 polygon',))
    """
    polygons = polygons_in(f)
    if polygons is None:
        faces = check_triangles(f)
        return faces, np.arange(len(faces)), ()
    corners, sizes = polygons
    cut = cut_polygons(v, corners, sizes)
    done = triangulation(int((sizes > 3).sum()), int(cut.concave.sum()))
    return corners[cut.triangles], cut.polygon, done


def triangulation(polygons: int, concave: int) -> tuple[str, ...]:
    """What was done to polygons, if there were any."""
    if not polygons:
        return ()
    among = f", {concave} of them concave" if concave else ""
    return (f"triangulated {plural(polygons, 'polygon')}{among}",)


def polygons_in(f: ArrayLike) -> tuple[IntArray, IntArray] | None:
    """The corners in one row, and the number of each face's, of an array of polygons; None of triangles and others.

    Rows of four or more indices, or as VTK and PyVista keep them: before each face's corners their number.
    """
    array = plain_array(f, "faces")
    if array.dtype.kind not in "iu" or not array.size or is_padded(array):
        return None
    if array.ndim == 2 and array.shape[1] > 3 and len(array) != 3:
        if (array[:, 0] == array.shape[1] - 1).all():
            array = array[:, 1:]
        return array.astype(np.int64).ravel(), np.full(len(array), array.shape[1])
    if array.ndim != 1:
        return None
    heads, at = [], 0
    while at < len(array) and array[at] >= 3:
        heads.append(at)
        at += int(array[at]) + 1
    if at != len(array):
        return None
    return np.delete(array, heads).astype(np.int64), array[heads].astype(np.int64)


@dataclass(frozen=True, eq=False)
class CutPolygons:
    """Triangles (k, 3) as places among the corners of polygons, and the polygon of each, in the order of polygons.

    `concave` (m,) says of which polygons a corner turns inwards.
    """

    triangles: IntArray
    polygon: IntArray
    concave: BoolArray


def cut_polygons(v: FloatArray, corners: IntArray, sizes: IntArray) -> CutPolygons:
    """Cut polygons, all corners in one row and the number of each one's, into triangles.

    All triangles of a polygon face the same way, and no new edge joins two vertices that an edge joins already. A fan
    about the first or the second corner is taken if it is so; else ears are cut off, the best-shaped first.

    >>> v = np.array([[1, 0, 0], [0, -0.5, 0], [-1, 0, 0], [0, -2, 0]])
    >>> cut = cut_polygons(v, np.arange(4), np.array([4]))
    >>> cut.triangles.tolist(), cut.concave.tolist()
    ([[1, 2, 3], [1, 3, 0]], [True])
    """
    first, n = np.cumsum(sizes) - sizes, len(v)
    polygon = np.repeat(np.arange(len(sizes)), sizes)
    after = np.arange(len(corners)) + 1
    after[first + sizes - 1] = first
    # whoever checks the faces refuses indices beyond
    p = own_unit(v)[0].take(corners, axis=0, mode="clip")
    p = p - p[first][polygon]
    normal = np.add.reduceat(np.cross(p, p[after]), first)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    before = np.empty_like(after)
    before[after] = np.arange(len(after))
    turns_in = _shape(p, np.column_stack((before, np.arange(len(after)), after)), normal[polygon])
    edges = edge_keys(corners, corners[after], n)
    fans = [_Fans(first, sizes, about) for about in (0, 1)]
    sound = np.array([fan.face_one_way(p, normal) for fan in fans])
    sound[:, sizes == 3] = [[True], [False]]  # triangles stay as they are
    left = np.ones(len(sizes), dtype=bool)
    triangles, owner = [np.empty((0, 3), dtype=np.int64)], [np.empty(0, dtype=np.int64)]
    for choices in (1, 2):  # those without a choice choose first
        for fan, right in zip(fans, sound, strict=True):
            ours = left & right & (sound.sum(axis=0) <= choices)
            if not ours.any():
                continue
            new, keys = fan.with_new_edges(corners, edges, ours, n)
            triangles.append(fan.triangles[new[fan.polygon]])
            owner.append(fan.polygon[new[fan.polygon]])
            edges, left = np.append(edges, keys), left & ~new
    taken = set[int]()
    if left.any():
        taken = set(edges.tolist())
    for k in np.flatnonzero(left).tolist():
        places = np.arange(first[k], first[k] + sizes[k])
        ears = _Ears(_in_plane(p[places], normal[k]), corners[places].tolist(), taken, n)
        triangles.append(places[np.array(ears.cut())])
        owner.append(np.full(sizes[k] - 2, k))
    order = np.argsort(np.concatenate(owner), kind="stable")
    return CutPolygons(
        np.concatenate(triangles)[order],
        np.concatenate(owner)[order],
        np.logical_or.reduceat(turns_in < -SIX_DIGITS, first),
    )


class _Fans:
    """Fans of all polygons about their corner `about`."""

    def __init__(self, first: IntArray, sizes: IntArray, about: int) -> None:
        count = sizes - 2
        self.polygon = np.repeat(np.arange(len(sizes)), count)
        step = np.arange(len(self.polygon)) - np.repeat(np.cumsum(count) - count, count)
        size, start = sizes[self.polygon], first[self.polygon]
        self.triangles = np.column_stack(
            [start + (about + k) % size for k in (0 * step, step + 1, step + 2)]
        )
        #: the last side of each triangle is an edge of the polygon in the last triangle alone
        self.inner = step < size - 3
        self._m = len(sizes)

    def face_one_way(self, p: FloatArray, normal: FloatArray) -> BoolArray:
        """Whether all triangles of each polygon face the way of its normal."""
        wrong = ~(_shape(p, self.triangles, normal[self.polygon]) > SIX_DIGITS)
        return np.bincount(self.polygon[wrong], minlength=self._m) == 0

    def with_new_edges(
        self, corners: IntArray, edges: IntArray, ours: BoolArray, n: int
    ) -> tuple[BoolArray, IntArray]:
        """Those of our polygons all of whose new edges are new, and these edges' keys."""
        inner = self.inner & ours[self.polygon]
        a, _, b = corners[self.triangles[inner]].T
        keys, owner = edge_keys(a, b, n), self.polygon[inner]
        _, index, count = np.unique(np.append(keys, edges), return_inverse=True, return_counts=True)
        new = ours.copy()
        new[owner[count[index[: len(keys)]] > 1]] = False
        return new, keys[new[owner]]


def _shape(p: FloatArray, triangles: IntArray, normal: FloatArray) -> FloatArray:
    """Twice the area over the square of the longest side, negative where a triangle faces against its normal."""
    a, b, c = (p[triangles[:, k]] for k in range(3))
    longest = np.max([np.square(side).sum(axis=1) for side in (b - a, c - b, a - c)], axis=0)
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), normal) / longest


def _in_plane(p: FloatArray, normal: FloatArray) -> FloatArray:
    """Positions (k, 2) in the plane across a normal."""
    along = np.cross(np.eye(3)[np.argmin(np.abs(normal))], normal)
    along /= np.linalg.norm(along)
    return np.column_stack((p @ along, p @ np.cross(normal, along)))


class _Ears:
    """Ears of a polygon: a corner, which turns outwards, with its neighbours, if no other corner is among them.

    `taken` are the keys of edges that are there.
    """

    def __init__(self, p: FloatArray, corners: list[int], taken: set[int], n: int) -> None:
        self._p, self._corners, self._taken, self._n = p, corners, taken, n
        k = len(corners)
        self._next, self._before = np.roll(np.arange(k), -1), np.roll(np.arange(k), 1)
        self._there = np.ones(k, dtype=bool)

    def cut(self) -> list[list[int]]:
        """Triangles (k - 2, 3) of places within the polygon."""
        score = np.array([self._score(k) for k in range(len(self._corners))])
        triangles = []
        for _ in range(len(self._corners) - 3):
            tip = int(np.argmax(score))
            before, after = int(self._before[tip]), int(self._next[tip])
            triangles.append([before, tip, after])
            self._taken.add(self._key(before, after))
            self._next[before], self._before[after] = after, before
            self._there[tip], score[tip] = False, -np.inf
            score[before], score[after] = self._score(before), self._score(after)
        one = int(np.argmax(self._there))
        triangles.append([int(self._before[one]), one, int(self._next[one])])
        return triangles

    def _key(self, a: int, b: int) -> int:
        low, high = sorted((self._corners[a], self._corners[b]))
        return low * self._n + high

    def _score(self, tip: int) -> float:
        """How good it is to cut a corner: the shape of its ear, best with a new edge, worst where it is no ear."""
        before, after = int(self._before[tip]), int(self._next[tip])
        a, b, c = self._p[[before, tip, after]]
        longest = max(float(side @ side) for side in (b - a, c - b, a - c))
        shape = 0.0
        if longest:
            shape = float(_cross(b - a, c - a)) / longest
        if not shape > SIX_DIGITS:
            return -1 + min(shape, 0.0)
        others = self._p[self._there]
        others = others[(others != a).any(axis=1) & (others != b).any(axis=1)]
        others = others[(others != c).any(axis=1)]
        within = np.ones(len(others), dtype=bool)
        for start, stop in ((a, b), (b, c), (c, a)):
            within &= _cross(stop - start, others - start) > -SIX_DIGITS * longest
        if within.any():
            return shape - 1
        score = shape + 1
        if self._key(before, after) in self._taken:
            score -= 1
        return score


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return a[0] * b[..., 1] - a[1] * b[..., 0]
