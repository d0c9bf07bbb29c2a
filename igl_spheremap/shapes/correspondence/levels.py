"""A surface at a resolution: its own mesh, or points spread evenly over its sphere."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.spatial import ConvexHull

from ...errors import MeshError, Remedy
from ...maps.given_sphere import certified
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import BoolArray, FloatArray, IntArray
from ...mesh.check import check_mesh
from ...mesh.edges import edge_keys
from ...mesh.measure import inside_out
from ...newton.system import VertexSystem
from ...resampling.locate import Location, locator_of
from ...resampling.transfer import weighted
from ...samples import sphere as regular_sphere
from ...sphere.rows import row_dets, row_lengths, unit_rows
from ...untangle.local_repair import unfolded
from ...verify.certificate import UNIT_TOLERANCE
from ...verify.signs import folded_faces


@dataclass(eq=False)
class Level:
    """A surface at a resolution.

    Attributes
    ----------
    map : SphereMap
        The surface and its map to the sphere, free of foldings.
    metric : (n, 3) float64 array
        Positions whose lengths are strained, of any scale: those of the surface, or smoothed ones.
    landmarks : (k,) int64 array
        Vertices that are to meet given points.
    own : Level, optional
        The surface's own mesh, unless it is this one.
    """

    map: SphereMap
    metric: FloatArray
    landmarks: IntArray
    own: Level | None = None
    _last: tuple[FloatArray, Location] | None = field(default=None, init=False)

    @classmethod
    def of(cls, result: SphereMap, name: str, landmarks: IntArray | None = None) -> Level:
        """Take a surface with its own mesh; a MeshError names a round sphere, or a surface inside out."""
        length = row_lengths(result.vertices)
        if np.ptp(length) < UNIT_TOLERANCE * length.mean() and np.allclose(
            result.vertices / length[:, None], result.sphere, rtol=0, atol=UNIT_TOLERANCE
        ):
            raise MeshError(
                f"{name} is a sphere, the map itself: strain is measured on surfaces; give the one that "
                "was mapped"
            )
        if inside_out(result.vertices, result.faces):
            raise MeshError(
                f"{name} is inside out: its faces point inwards; reverse them",
                Remedy("repair_mesh"),
            )
        if landmarks is None:
            landmarks = np.empty(0, dtype=np.int64)
        return cls(result, result.mesh.unit, landmarks)

    def coarser(self, size: int) -> Level:
        """Take about `size` points spread evenly over the sphere, with the landmarks, and triangulate them (Delaunay).

        If points and landmarks are nearer than half the spacing, only landmarks are kept.
        """
        x, kept = regular_sphere(size)[0], self.map.sphere[self.landmarks]
        for landmark in kept:
            x = x[np.linalg.norm(x - landmark, axis=1) > np.sqrt(np.pi / size)]
        x = np.concatenate((kept, x))
        v = self.at(x, self.map.mesh.v)
        return Level(
            certified(check_mesh(v, hull_faces(x)), x),
            self.at(x, self.metric),
            np.arange(len(kept)),
            self,
        )

    @cached_property
    def system(self) -> VertexSystem:
        """The pattern of Newton's equations on this mesh."""
        return VertexSystem(self.map.faces, len(self.map.sphere))

    def locate(self, y: FloatArray) -> Location:
        """Locate points; the last answer is kept, since all terms of a problem ask for the same points."""
        if self._last is None or self._last[0] is not y:
            self._last = y, locator_of(self.map).locate(y)
        return self._last[1]

    def at(self, y: FloatArray, values: FloatArray) -> FloatArray:
        """Interpolate values at the vertices at points of the sphere."""
        face, weights = self.locate(y)
        return weighted(values, self.map.faces[face], weights, labels=False)

    def carried(self, y: FloatArray, other: Level) -> FloatArray:
        """Interpolate the map y of this level at the vertices of another one, and unfold it."""
        return unfolded(other.map.mesh, unit_rows(self.at(other.map.sphere, y)))

    def split(self, y: FloatArray, marked: BoolArray) -> tuple[Level, FloatArray]:
        """Bisect edges of marked faces; return that level and its map, which extends y: new vertices come last."""
        own = self.map.mesh
        edges = np.stack(
            [row_lengths(y[own.f[:, k - 2]] - y[own.f[:, k - 1]]) for k in range(3)], axis=1
        )
        f, ends, parts = bisected(own.f, edges * marked[:, None], len(y))
        v, metric, x, z = (
            np.concatenate((p, p[ends].mean(axis=1)))
            for p in (own.v, self.metric, self.map.sphere, y)
        )
        x[len(y) :], z[len(y) :] = unit_rows(x[len(y) :]), unit_rows(z[len(y) :])
        if folded_faces(x, f).any() or folded_faces(z, f).any():  # slivers, by rounding
            return self, y
        caps = own.caps
        if caps is not None:
            caps = caps[parts]
        own_mesh = self
        if self.own is not None:
            own_mesh = self.own
        found = certified(check_mesh(v, f, caps=caps), x)
        return Level(found, metric, self.landmarks, own_mesh), z


def bisected(f: IntArray, length: FloatArray, n: int) -> tuple[IntArray, IntArray, IntArray]:
    """Bisect edges; return the faces, the ends (k, 2) of these edges, and the old face of each face.

    `length` (m, 3) are the lengths of the edges opposite the corners, 0 for edges that may not be bisected. If an edge
    is the longest of both its faces, it is bisected; the midpoints are vertices n, n + 1, ...
    """
    face = np.arange(len(f))
    corner = length.argmax(axis=1)
    i, j = f[face, corner - 2], f[face, corner - 1]  # counter-clockwise
    key = np.where(length.max(axis=1) > 0, edge_keys(i, j, n), -1 - face)
    _, first, pair, count = np.unique(
        key, return_index=True, return_inverse=True, return_counts=True
    )
    pair = pair.reshape(-1)
    number = np.cumsum(count == 2) - 1
    cut = np.flatnonzero(count[pair] == 2)
    k, middle = f[cut, corner[cut]], n + number[pair[cut]]
    whole = np.delete(face, cut)
    ends = np.column_stack((i[first[count == 2]], j[first[count == 2]]))
    halves = np.column_stack((k, i[cut], middle)), np.column_stack((k, middle, j[cut]))
    return np.concatenate((f[whole], *halves)), ends, np.concatenate((whole, cut, cut))


def hull_faces(x: FloatArray) -> IntArray:
    """Triangulate points of the sphere by their convex hull, outwards: their Delaunay triangulation.

    >>> hull_faces(np.vstack((np.eye(3), -np.eye(3)))).shape
    (8, 3)
    """
    f = ConvexHull(x).simplices.astype(np.int64)
    inward = row_dets(x[f[:, 0]], x[f[:, 1]], x[f[:, 2]]) < 0
    f[inward] = f[inward][:, ::-1]
    return f
