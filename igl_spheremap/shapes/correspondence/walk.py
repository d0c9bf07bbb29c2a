"""Edges of one spherical triangulation followed through the faces of another.

All decisions are exact signs of determinants, so ties are exact, too. A vertex may lie at a vertex or on an edge of the
other mesh, and edges may run along each other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...mesh.arrays import BoolArray, FloatArray, IntArray
from ...mesh.check import Mesh
from ...mesh.edges import half_edges_out, sides
from ...resampling.locate import Location, SphereLocator
from ...sphere.rows import unit_rows
from ...verify.signs import determinant_signs


class Triangulation:
    """A mesh with positive faces on the sphere, and its half-edges in order around each vertex.

    Attributes
    ----------
    x : (n, 3) float64 array
        Unit rows.
    f : (m, 3) int64 array
        Faces.
    start, end, twin : (3 m,) int64 arrays
        Of each half-edge: its vertices, and the half-edge that runs back.
    forward : (3 n - 6,) int64 array
        The half-edge from the smaller to the larger vertex of each edge.
    """

    def __init__(self, mesh: Mesh, x: FloatArray) -> None:
        self.x, self.f = unit_rows(x), mesh.f
        self.locator = SphereLocator(self.x, mesh)
        self.start, self.end = sides(mesh.f)
        self._edges = mesh.edges
        self.twin = mesh.edges.twins().astype(np.int64)
        self.forward = np.flatnonzero(self.start < self.end)

    def edge(self, h: IntArray) -> IntArray:
        """Return the number of each half-edge's edge: the smaller one of its two half-edges."""
        return np.minimum(h, self.twin[h])

    def apex(self, h: IntArray) -> IntArray:
        """Return the vertex opposite each half-edge."""
        return self.f.ravel()[h]

    def leave(self, vertex: IntArray, towards: FloatArray) -> tuple[IntArray, BoolArray]:
        """Return the half-edge out of each vertex at a target, or next to it clockwise, and whether it points at it."""
        ray, out = half_edges_out(self._edges, vertex)
        h = out.astype(np.int64)
        centre, target = self.x[vertex][ray], towards[ray]
        right = determinant_signs(centre, self.x[self.end[h]], target)
        left = determinant_signs(centre, self.x[self.apex(h)], target)
        # one of the wedges, each with its right side and without its left one
        holds = (right >= 0) & (left < 0)
        return h[holds], right[holds] == 0


@dataclass(frozen=True, eq=False)
class ExactLocation:
    """Points on a triangulation.

    Attributes
    ----------
    location : Location
        Weights are exactly 0 at corners that have no part in the point.
    corners : (k,) int64 array
        Number of corners with a part: 1 at a vertex, 2 on a side, 3 within a face.
    part : (k,) int64 array
        That vertex, that side as a half-edge, or that face.
    """

    location: Location
    corners: IntArray
    part: IntArray

    def rows(self, points: IntArray, corners: int) -> tuple[IntArray, IntArray]:
        """Return the points at a vertex (1), on a side (2) or within a face (3), and its number."""
        rows = np.flatnonzero(self.corners[points] == corners)
        return rows, self.part[points[rows]]


def locate_exactly(points: FloatArray, on: Triangulation) -> ExactLocation:
    """Locate unit rows, by exact signs."""
    face, weights = on.locator.locate(points)
    corners = [on.x[on.f[face, k]] for k in range(3)]
    inner = np.stack(
        [determinant_signs(points, corners[k - 2], corners[k - 1]) != 0 for k in range(3)], axis=1
    )
    count = inner.sum(axis=1)
    weights = np.where(inner, weights, 0.0)
    weights[count == 1] = inner[count == 1]
    part = np.choose(
        count - 1, (on.f[face, inner.argmax(axis=1)], 3 * face + inner.argmin(axis=1), face)
    )
    return ExactLocation(Location(face, weights / weights.sum(axis=1, keepdims=True)), count, part)


@dataclass(frozen=True, eq=False)
class Segments:
    """Edges of a mesh, cut at another mesh's edges.

    Attributes
    ----------
    edge, start, end : (k,) int64 arrays
        The edge of each segment, and the nodes at its ends, in the direction from smaller to larger vertex.
    half : (k,) int64 array
        A half-edge of the other mesh: of the face that the segment crosses, or the one that it runs along.
    along : (k,) bool array
        Whether it runs along that.
    crossed : (c, 2) int64 array
        Of each crossing with an edge of the other mesh, the edge and the half-edge by which it left a face.
    """

    edge: IntArray
    start: IntArray
    end: IntArray
    half: IntArray
    along: BoolArray
    crossed: IntArray


def walk(
    path: Triangulation,
    over: Triangulation,
    found: ExactLocation,
    own: IntArray,
    other: IntArray,
    first: int,
) -> Segments:
    """Follow all edges of `path` through `over`, a face at a time.

    `found` are the places of the vertices of `path`, `own` and `other` the nodes at the vertices of both; crossings
    become nodes from the number `first` on.
    """
    a, b = path.start[path.forward], path.end[path.forward]
    i = np.arange(len(a))
    node = own[a]  # the end of each edge so far
    h, along = _begin(path.x[a], path.x[b], over, found, a)
    segments, crossed = [], [np.empty((0, 2), dtype=np.int64)]

    def go(i: IntArray, to: IntArray, h: IntArray, along: BoolArray) -> None:
        segments.append((i, node[i], to, h, along))
        node[i] = to

    while len(i):
        there = _ends(over, h, along, found, b[i])
        go(i[there], own[b[i[there]]], h[there], along[there])
        i, h, along = i[~there], h[~there], along[~there]
        # The half-edge h has its start to the left of the path and its end to the right, or runs along it.
        apex = determinant_signs(path.x[a[i]], path.x[b[i]], over.x[over.apex(h)])
        meets = along | (apex == 0)
        vertex = np.where(along, over.end[h], over.apex(h))[meets]
        out = (h - h % 3 + (h + np.where(apex > 0, 1, 2)) % 3)[~meets]
        to = np.empty_like(i)
        to[meets], to[~meets] = other[vertex], np.arange(first, first + len(out))
        first += len(out)
        crossed.append(np.column_stack((i[~meets], out)))
        go(i, to, h, along)
        h, along = np.empty_like(h), np.zeros_like(along)
        h[~meets] = over.twin[out]
        h[meets], along[meets] = over.leave(vertex, path.x[b[i[meets]]])
    edge, start, end, half, runs = (
        np.concatenate(column) for column in zip(*segments, strict=True)
    )
    return Segments(edge, start, end, half, runs, np.concatenate(crossed))


def _begin(
    a: FloatArray, b: FloatArray, over: Triangulation, found: ExactLocation, vertices: IntArray
) -> tuple[IntArray, BoolArray]:
    """Return the first half-edge of each path from a to b, and whether it runs along it."""
    h, along = np.empty(len(a), dtype=np.int64), np.zeros(len(a), dtype=bool)
    rows, vertex = found.rows(vertices, 1)
    h[rows], along[rows] = over.leave(vertex, b[rows])
    rows, side = found.rows(vertices, 2)
    h[rows], along[rows] = _from_side(over, side, a[rows], b[rows])
    rows, face = found.rows(vertices, 3)
    h[rows] = _from_face(over, face, a[rows], b[rows])
    return h, along


def _from_side(
    over: Triangulation, side: IntArray, a: FloatArray, b: FloatArray
) -> tuple[IntArray, BoolArray]:
    """Return the half-edges of sides at beginnings of paths, in the face that they enter, or in their own direction."""
    turn = determinant_signs(over.x[over.start[side]], over.x[over.end[side]], b)
    back = determinant_signs(a, over.x[over.apex(side)], b)
    return np.where((turn > 0) | (turn == 0) & (back < 0), side, over.twin[side]), turn == 0


def _from_face(over: Triangulation, face: IntArray, a: FloatArray, b: FloatArray) -> IntArray:
    """Return the half-edges by which paths leave faces: the start lies to the right, the end to the left or on it."""
    signs = np.column_stack([determinant_signs(a, b, over.x[over.f[face, k]]) for k in range(3)])
    leaves = (np.roll(signs, 1, axis=1) < 0) & (
        (signs > 0) | (signs == 0) & (np.roll(signs, -1, axis=1) > 0)
    )
    return 3 * face + leaves.argmax(axis=1)


def _ends(
    over: Triangulation, h: IntArray, along: BoolArray, found: ExactLocation, b: IntArray
) -> BoolArray:
    """Say which paths end here: in the face that they cross, its boundary included, or on the side they run along."""
    ends, face = np.zeros(len(b), dtype=bool), h // 3
    rows, vertex = found.rows(b, 1)
    ends[rows] = np.where(
        along[rows], over.end[h[rows]] == vertex, (vertex == over.f[face[rows]].T).any(axis=0)
    )
    rows, side = found.rows(b, 2)
    own = np.where(along[rows], h[rows], face[rows])
    sides = side, over.twin[side]
    ends[rows] = np.any([own == np.where(along[rows], each, each // 3) for each in sides], axis=0)
    rows, within = found.rows(b, 3)
    ends[rows] = ~along[rows] & (within == face[rows])
    return ends
