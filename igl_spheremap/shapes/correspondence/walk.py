"""Edges of one spherical triangulation followed through the faces of another.

All decisions are exact signs of determinants, so ties are exact, too: a vertex may lie at a vertex or on an edge of the
other mesh, and edges may run along each other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...mesh.arrays import BoolArray, FloatArray, IntArray
from ...mesh.check import Mesh
from ...resampling.locate import Location, SphereLocator
from ...sphere.rows import unit_rows
from ...verify.signs import determinant_signs


class Triangulation:
    """A mesh with positive faces on the sphere; half-edge 3 i + k runs along the side of face i opposite corner k.

    Attributes
    ----------
    x : (n, 3) float64 array
        Unit rows.
    f : (m, 3) int64 array
        Faces.
    start, end, twin, edge : (3 m,) int64 arrays
        Of each half-edge: its vertices, the half-edge that runs back, and the number of its edge.
    forward : (3 n - 6,) int64 array
        Of each edge, the half-edge from its smaller to its larger vertex.
    """

    def __init__(self, mesh: Mesh, x: FloatArray) -> None:
        self.x, self.f = unit_rows(x), mesh.f
        self.locator = SphereLocator(self.x, mesh)
        self.start, self.end = np.roll(mesh.f, -1, axis=1).ravel(), np.roll(mesh.f, -2, axis=1).ravel()
        between = mesh.edges.half < 3 * len(mesh.f)  # the other entries are those of vertices
        self._out = mesh.edges.half[between].astype(np.int64)
        self._first = mesh.edges.indptr - np.arange(len(x) + 1)
        self.twin = np.empty(3 * len(mesh.f), dtype=np.int64)
        self.twin[self._out] = mesh.edges.twin[between]
        self.forward = np.flatnonzero(self.start < self.end)
        self.edge = np.empty_like(self.twin)
        self.edge[self.forward] = self.edge[self.twin[self.forward]] = np.arange(len(self.forward))

    def apex(self, h: IntArray) -> IntArray:
        """The vertex opposite each half-edge."""
        return self.f.ravel()[h]

    def leave(self, vertex: IntArray, towards: FloatArray) -> tuple[IntArray, BoolArray]:
        """The half-edge out of each vertex that points at a direction, or is next to it clockwise; whether it does."""
        degree = self._first[vertex + 1] - self._first[vertex]
        ray = np.repeat(np.arange(len(vertex)), degree)
        nth = np.arange(len(ray)) - np.repeat(np.cumsum(degree) - degree, degree)
        h = self._out[self._first[vertex][ray] + nth]
        centre, target = self.x[vertex][ray], towards[ray]
        right = determinant_signs(centre, self.x[self.end[h]], target)
        left = determinant_signs(centre, self.x[self.apex(h)], target)
        holds = (right >= 0) & (left < 0)  # one of the wedges, each with its right side and without its left one
        return h[holds], right[holds] == 0


@dataclass(frozen=True, eq=False)
class Places:
    """Where points lie on a triangulation: the face, and the side or the vertex where it is one, else -1.

    Weights are exactly 0 at corners that have no part in the point.
    """

    location: Location
    side: IntArray
    vertex: IntArray


def places(points: FloatArray, on: Triangulation) -> Places:
    """Where unit rows lie."""
    face, weights = on.locator.locate(points)
    corners = [on.x[on.f[face, k]] for k in range(3)]
    inner = np.stack([determinant_signs(points, corners[k - 2], corners[k - 1]) != 0 for k in range(3)], axis=1)
    parts = inner.sum(axis=1)
    weights = np.where(inner, weights, 0.0)
    weights[parts == 1] = inner[parts == 1]
    side = np.where(parts == 2, 3 * face + inner.argmin(axis=1), -1)
    vertex = np.where(parts == 1, on.f[face, inner.argmax(axis=1)], -1)
    return Places(Location(face, weights / weights.sum(axis=1, keepdims=True)), side, vertex)


@dataclass(frozen=True, eq=False)
class Segments:
    """Edges of a mesh cut where they meet another one.

    Attributes
    ----------
    edge, start, end : (k,) int64 arrays
        The edge of each segment, and the nodes at its ends, in the direction from smaller to larger vertex.
    half : (k,) int64 array
        A half-edge of the other mesh: of the face that the segment crosses, or the one that it runs along.
    along : (k,) bool array
        Which of the two.
    crossed : (c, 2) int64 array
        Of each crossing with an edge of the other mesh, the edge and the half-edge by which it left a face.
    """

    edge: IntArray
    start: IntArray
    end: IntArray
    half: IntArray
    along: BoolArray
    crossed: IntArray


def walk(path: Triangulation, over: Triangulation, found: Places, own: IntArray, other: IntArray,
         first: int) -> Segments:
    """Follow all edges of `path` through `over`, a face at a time.

    `found` are the places of the vertices of `path`, `own` and `other` the nodes at the vertices of both; crossings
    become nodes from the number `first` on.
    """
    a, b = path.start[path.forward], path.end[path.forward]
    i = np.arange(len(a))
    node = own[a]  # where each edge has been followed to
    h, along = _begin(path.x[a], path.x[b], over, found, a)
    segments, crossed = [], [np.empty((0, 2), dtype=np.int64)]

    def go(i: IntArray, to: IntArray, h: IntArray, along: BoolArray) -> None:
        segments.append((i, node[i], to, h, along))
        node[i] = to

    while len(i):
        there = np.where(along, _on_edge(over, h, found, b[i]), _in_face(over, h // 3, found, b[i]))
        go(i[there], own[b[i[there]]], h[there], along[there])
        i, h, along = i[~there], h[~there], along[~there]
        # The half-edge h has its start to the left of the path and its end to the right, or runs along it.
        apex = determinant_signs(path.x[a[i]], path.x[b[i]], over.x[over.apex(h)])
        vertex = np.where(along, over.end[h], np.where(apex == 0, over.apex(h), -1))
        out = h - h % 3 + (h + np.where(apex > 0, 1, 2)) % 3
        crosses = vertex < 0
        to = other[vertex]
        to[crosses] = first + np.arange(crosses.sum())
        first += int(crosses.sum())
        crossed.append(np.stack((i[crosses], out[crosses]), axis=1))
        go(i, to, h, along)
        along = np.zeros(len(i), dtype=bool)
        h = over.twin[out]
        h[~crosses], along[~crosses] = over.leave(vertex[~crosses], path.x[b[i[~crosses]]])
    edge, start, end, half, runs = (np.concatenate(column) for column in zip(*segments, strict=True))
    return Segments(edge, start, end, half, runs, np.concatenate(crossed))


def _begin(a: FloatArray, b: FloatArray, over: Triangulation, found: Places, vertices: IntArray) -> tuple[
        IntArray, BoolArray]:
    """The first half-edge of each path from a to b, as `walk` keeps it."""
    face, side, vertex = found.location.face[vertices], found.side[vertices], found.vertex[vertices]
    along = np.zeros(len(a), dtype=bool)
    inside = np.flatnonzero((side < 0) & (vertex < 0))
    corners = over.f[face[inside]]
    signs = np.stack([determinant_signs(a[inside], b[inside], over.x[corners[:, k]]) for k in range(3)], axis=1)
    # The path leaves by a side with its start to the right and its end to the left, or on the path.
    leaves = (np.roll(signs, 1, axis=1) < 0) & ((signs > 0) | (signs == 0) & (np.roll(signs, -1, axis=1) > 0))
    h = 3 * face
    h[inside] += leaves.argmax(axis=1)
    on = np.flatnonzero(side >= 0)
    g = side[on]
    turn = determinant_signs(over.x[over.start[g]], over.x[over.end[g]], b[on])
    back = determinant_signs(a[on], over.x[over.apex(g)], b[on])
    h[on] = np.where((turn > 0) | (turn == 0) & (back < 0), g, over.twin[g])
    along[on] = turn == 0
    at = np.flatnonzero(vertex >= 0)
    h[at], along[at] = over.leave(vertex[at], b[at])
    return h, along


def _in_face(over: Triangulation, face: IntArray, found: Places, b: IntArray) -> BoolArray:
    """Whether points of `found` lie in a face or on its boundary."""
    vertex, side = found.vertex[b], found.side[b]
    beside = (side // 3 == face) | (over.twin[side] // 3 == face)
    corner = (over.f[face] == vertex[:, None]).any(axis=1)
    return np.where(vertex >= 0, corner, np.where(side >= 0, beside, found.location.face[b] == face))


def _on_edge(over: Triangulation, h: IntArray, found: Places, b: IntArray) -> BoolArray:
    """Whether points of `found` lie on a half-edge or at its end."""
    vertex, side = found.vertex[b], found.side[b]
    return np.where(vertex >= 0, vertex == over.end[h], (side == h) | (side == over.twin[h]))
