"""A surface at a resolution: its own mesh, or points spread evenly over its sphere."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import ConvexHull

from ..mesh.arrays import FloatArray, IntArray
from ..mesh.check import Mesh, check_mesh
from ..newton.system import VertexSystem
from ..result.sphere_map import SphereMap
from ..samples import sphere as regular_sphere
from ..shapes.locate import Location, SphereLocator
from ..shapes.transfer import weighted
from ..sphere.rows import row_dets, unit_rows
from ..untangle.local_repair import repair_locally
from ..verify.signs import folded_faces


@dataclass(frozen=True, eq=False)
class Level:
    """A surface at a resolution.

    Attributes
    ----------
    mesh : Mesh
        The surface.
    x : (n, 3) float64 array
        Its map to the sphere, free of foldings.
    landmarks : (k,) int64 array
        Vertices that are to meet given points.
    location : Location, optional
        Where the vertices lie on the surface's own mesh, if that is another one.
    """

    mesh: Mesh
    x: FloatArray
    landmarks: IntArray
    location: Location | None = None

    @classmethod
    def of(cls, result: SphereMap, landmarks: IntArray) -> Level:
        """A surface's own mesh."""
        return cls(result.mesh, result.sphere, landmarks)

    def coarser(self, size: int) -> Level:
        """About `size` points spread evenly over the sphere, beside the landmarks, and their Delaunay triangulation.

        Of points and landmarks nearer than half the spacing only landmarks are kept.
        """
        x, kept = regular_sphere(size)[0], self.x[self.landmarks]
        for landmark in kept:
            x = x[np.linalg.norm(x - landmark, axis=1) > np.sqrt(np.pi / size)]
        x = np.concatenate((kept, x))
        location = self.locator.locate(x)
        v = weighted(self.mesh.vertices, self.f[location.face], location.weights, labels=False)
        return Level(check_mesh(v, hull_faces(x)), x, np.arange(len(kept)), location)

    @property
    def v(self) -> FloatArray:
        """Positions."""
        return self.mesh.v

    @property
    def f(self) -> IntArray:
        """Faces."""
        return self.mesh.f

    @cached_property
    def locator(self) -> SphereLocator:
        """Finds points of the sphere."""
        return SphereLocator(self.x, self.mesh)

    @cached_property
    def system(self) -> VertexSystem:
        """Newton's equations."""
        return VertexSystem(self.f, len(self.x))

    def carried(self, y: FloatArray, other: Level) -> FloatArray:
        """A map of another level that is like the map y of this one, free of foldings."""
        face, weights = self.locator.locate(other.x)
        z = unit_rows(weighted(y, self.f[face], weights, labels=False))
        return repair_locally(other.mesh, z) if folded_faces(z, other.f).any() else z


def hull_faces(x: FloatArray) -> IntArray:
    """Faces of the convex hull of points of the sphere, oriented outwards: their Delaunay triangulation.

    >>> hull_faces(np.vstack((np.eye(3), -np.eye(3)))).shape
    (8, 3)
    """
    f = ConvexHull(x).simplices.astype(np.int64)
    inward = row_dets(x[f[:, 0]], x[f[:, 1]], x[f[:, 2]]) < 0
    f[inward] = f[inward][:, ::-1]
    return f
