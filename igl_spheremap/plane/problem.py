"""Newton steps over maps of a disk to the plane: on a circle, or with a free boundary; and a quadratic energy."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..balance.flat_faces import FlatFaces
from ..mesh.arrays import BoolArray, FloatArray, IntArray
from ..mesh.disk import Disk
from ..mesh.edges import half_edges_from
from ..newton.faces import FaceEnergy, FaceProblem
from ..newton.loop import Model
from ..newton.system import gram_blocks
from ..verify.rim import plane_signs, rim_crossings

#: Radius of the disk whose area is that of `FlatFaces`, 4 pi.
RADIUS = 2.0


class CircleProblem(FaceProblem):
    """Lower an energy over maps to the disk of radius 2, whose boundary vertices move along the circle."""

    def __init__(self, energy: FaceEnergy, disk: Disk) -> None:
        super().__init__(energy)
        self._rim = np.zeros(len(disk.v), dtype=bool)
        self._rim[disk.rim] = True

    def axes(self, x: FloatArray) -> FloatArray:
        """The two coordinates; at the boundary the circle's tangent, and nothing."""
        axes = _coordinates(len(x))
        axes[0][:, self._rim] = np.stack((-x[self._rim, 1], x[self._rim, 0])) / RADIUS
        axes[1][:, self._rim] = 0
        return axes

    def model(self, x: FloatArray) -> Model:
        """The model of the plane, with an entry for the unknowns that move nothing."""
        model = super().model(x)
        at_vertices = np.zeros((2, 2, len(x)))
        at_vertices[1, 1, self._rim] = 1
        return Model(model.value, model.axes, model.gradient, model.blocks, at_vertices)

    def onto(self, points: FloatArray, rows: BoolArray | slice) -> FloatArray:
        """Boundary vertices back on the circle."""
        rim = self._rim[rows]
        points[rim] *= RADIUS / np.hypot(points[rim, 0], points[rim, 1])[:, None]
        return points

    def folded(self, x: FloatArray, faces: IntArray | slice) -> BoolArray:
        """Faces that are not positive."""
        return np.asarray(plane_signs(x, self.energy.f[faces]) <= 0)


class FreeProblem(FaceProblem):
    """Lower an energy over maps to the plane whose boundary is free, and crosses itself nowhere."""

    def __init__(self, energy: FaceEnergy, disk: Disk) -> None:
        super().__init__(energy)
        self._rim = disk.rim
        # The face of each edge of the boundary, in its order.
        self._at_rim = half_edges_from(disk.f, len(disk.v), disk.rim, np.roll(disk.rim, -1)) // 3

    def axes(self, x: FloatArray) -> FloatArray:
        """The two coordinates."""
        return _coordinates(len(x))

    def onto(self, points: FloatArray, rows: BoolArray | slice) -> FloatArray:
        """The points themselves."""
        return points

    def folded(self, x: FloatArray, faces: IntArray | slice) -> BoolArray:
        """Faces that are not positive, and those at the edges at which the boundary crosses itself."""
        folded = np.zeros(len(self.energy.f), dtype=bool)
        folded[faces] = plane_signs(x, self.energy.f[faces]) <= 0
        folded[self._at_rim[rim_crossings(x, self._rim)]] = True
        return folded[faces]


class ConformalEnergy:
    """Sum over faces of half their weight times (s1 - s2)^2, with the stretches s1 >= s2 of their maps.

    Each face counts by its area, times the growth of areas by stereographic projection where a given map has the face:
    as if its image were on the half of a sphere, as that of a doubled surface. At a jagged boundary, which no conformal
    map takes to a circle, only the faces there are distorted.

    Parameters
    ----------
    source : FlatFaces
        The mesh.
    x : (n, 2) float64 array
        A map to the disk of radius 2 without foldings.
    """

    def __init__(self, source: FlatFaces, x: FloatArray) -> None:
        self.source, self.f = source, source.f
        middle = x.take(source.corners, axis=0).mean(axis=0) / RADIUS
        self.area = source.area * (2 / (1 + (middle * middle).sum(axis=1))) ** 2

    @cached_property
    def _hats(self) -> FloatArray:
        """Gradients (coordinate, corner, face) of the hat functions of all corners."""
        first, second = self.source.hats.transpose(1, 0, 2)
        return np.stack((-first - second, first, second), axis=1)

    def by_face(self, x: FloatArray, faces: IntArray | slice = slice(None)) -> FloatArray:
        """Energies of the given faces."""
        shear = self._shears(x, faces)
        return self.area[faces] * (shear * shear).sum(axis=0) / 2

    def derivatives(self, x: FloatArray, axes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gradient (2, n) and blocks (6, 2, 2, m) along the vertices' axes (2, 2, n)."""
        h, corners = self._hats, self.source.corners
        across, up = axes.take(corners, axis=2).transpose(1, 2, 0, 3)  # coordinate; corner, axis, face
        rows = np.stack((h[0][:, None] * across - h[1][:, None] * up, h[1][:, None] * across + h[0][:, None] * up))
        slopes = np.einsum("rm,rcam->acm", self.area * self._shears(x), rows)
        gradient = [np.bincount(corners.ravel(), slope.ravel(), self.source.n) for slope in slopes]
        return np.stack(gradient), gram_blocks(self.area * rows, rows)

    def _shears(self, x: FloatArray, faces: IntArray | slice = slice(None)) -> FloatArray:
        """The part of each face's map that is not a similarity, a complex number as (2, m); its size is s1 - s2."""
        h = self._hats[:, :, faces]
        a, b = np.ascontiguousarray(x.T).take(self.source.corners[:, faces], axis=1)
        return np.stack(((h[0] * a - h[1] * b).sum(axis=0), (h[1] * a + h[0] * b).sum(axis=0)))


def _coordinates(n: int) -> FloatArray:
    return np.repeat(np.eye(2)[:, :, None], n, axis=2)
