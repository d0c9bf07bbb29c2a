"""The balanced energy of a map: angles against areas, face by face."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..mesh.arrays import FloatArray, IntArray
from ..sphere.rows import column_crosses
from .source import Source


@dataclass(frozen=True, eq=False)
class Energy:
    """Sum over the faces of a [(1 - w) phi(q) + w phi(p - target)], docs/balance.md (3).

    Attributes
    ----------
    source : Source
        The mesh.
    weight : float
        w in [0, 1]: 0 counts angles only, 1 areas only.
    power : float
        k of phi: 0 for squares of logarithms, 1 for MIPS and J + 1/J; above 0 a fold costs infinitely much.
    target : (m,) float64 array
        Logarithm of image area over source area that each face is to have.
    """

    source: Source
    weight: float
    power: float
    target: FloatArray

    @cached_property
    def aim(self) -> FloatArray:
        """Area that each face is to have."""
        return np.asarray(self.source.area * np.exp(self.target))

    def by_face(self, x: FloatArray, faces: IntArray | slice = slice(None)) -> FloatArray:
        """Energies of the given faces; infinite where one is folded."""
        image, dirichlet = project(self.source, x, faces)
        free = image > 0
        image = np.where(free, image, 1.0)
        cosh = np.maximum(dirichlet / image, 1.0)  # balance (2)
        with np.errstate(over="ignore", invalid="ignore"):  # a bad trial step
            angles, areas = self.phi(cosh + np.sqrt(cosh * cosh - 1)), self.phi(image / self.aim[faces])
            value = self.source.area[faces] * ((1 - self.weight) * angles + self.weight * areas)  # balance (3)
        return np.where(free, value, np.inf)

    def area_error(self, x: FloatArray) -> float:
        """Mean of |p - target| over the source's area."""
        area = self.source.area
        return float((area * np.abs(log_areas(self.source, x) - self.target)).sum() / area.sum())

    def phi(self, ratio: FloatArray) -> FloatArray:
        """u^2, or 2 (cosh(k u) - 1) / k^2, of the logarithm u of a ratio, docs/balance.md (4)."""
        if self.power == 0:
            return np.asarray(np.log(ratio) ** 2)
        power = ratio**self.power
        return np.asarray((power - 1) ** 2 / (power * self.power**2))  # balance (4)

    def slopes(self, ratio: FloatArray) -> tuple[FloatArray, FloatArray]:
        """First and second derivative of phi by u."""
        if self.power == 0:
            return 2.0 * np.log(ratio), np.full_like(ratio, 2.0)
        power = ratio**self.power
        return (power - 1 / power) / self.power, power + 1 / power


def project(source: Source, x: FloatArray, faces: IntArray | slice = slice(None)) -> tuple[FloatArray, FloatArray]:
    """Signed areas and Dirichlet energies of image faces in planes across their centroids, docs/balance.md (1)."""
    p = np.ascontiguousarray(x.T).take(source.f[faces].T, axis=1)  # coordinate, corner, face
    side = p[:, [2, 0, 1]] - p[:, [1, 2, 0]]  # opposite each corner
    outward = p.sum(axis=1)
    length = np.sqrt(np.einsum("cm,cm->m", outward, outward))
    outward /= np.where(length > 0, length, 1.0)
    square = np.einsum("cim,cim->im", side, side) - np.einsum("cim,cm->im", side, outward) ** 2
    image = 0.5 * np.einsum("cm,cm->m", column_crosses(side[:, 2], -side[:, 1]), outward)
    return image, 0.25 * np.einsum("im,im->m", source.cot[:, faces], square)


def log_areas(source: Source, x: FloatArray) -> FloatArray:
    """Logarithm p of image area over source area by face, of a map free of foldings."""
    return np.asarray(np.log(np.maximum(project(source, x)[0], np.finfo(float).tiny) / source.area))
