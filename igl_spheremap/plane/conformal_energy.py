"""What keeps a map to the plane from being conformal, face by face: a quadratic function of the map."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..balance.energy import FlatFaces
from ..balance.family import log_factor
from ..mesh.arrays import FloatArray, IntArray
from ..newton.system import gram_blocks


class ConformalEnergy:
    """Sum over faces of half their weight times (s1 - s2)^2, with the stretches s1 >= s2 of their maps.

    Each face counts by its area, divided by how much areas around it grow in a given map. The minimum is harmonic, and
    faces at a jagged boundary, which no conformal map keeps, bend alone.

    Parameters
    ----------
    source : FlatFaces
        The mesh.
    x : (n, 2) float64 array
        A map to the plane without foldings.
    """

    def __init__(self, source: FlatFaces, x: FloatArray) -> None:
        self.source, self.f = source, source.f
        self.area = source.area * np.exp(-log_factor(source, x))

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
        """The part of each face's map that is no similarity, a complex number as (2, m); its size is s1 - s2."""
        h = self._hats[:, :, faces]
        a, b = np.ascontiguousarray(x.T).take(self.source.corners[:, faces], axis=1)
        return np.stack(((h[0] * a - h[1] * b).sum(axis=0), (h[1] * a + h[0] * b).sum(axis=0)))
