"""The balanced energy of a map: angles against areas, face by face."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .source import Source

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Energy:
    """Sum over the faces of a [(1 - w) phi(q) + w phi(p - target)], docs/balance.md (3).

    Attributes
    ----------
    source : Source
        The mesh.
    weight : float
        w in [0, 1]: 0 counts angles only, 1 areas only.
    power : int
        k of phi: 0 for squares of logarithms, 1 for MIPS and J + 1/J, which are polyconvex barriers.
    target : (m,) float64 array
        Logarithm of image area over source area that each face is to have.
    """

    source: Source
    weight: float
    power: int
    target: FloatArray

    def by_face(self, x: FloatArray, faces: IntArray | slice = slice(None)) -> FloatArray:
        """Energies of the given faces; infinite where one is folded."""
        source = self.source
        area, target = source.area[faces], self.target[faces]
        image, dirichlet = project(source, x, faces)
        free = image > 0
        image = np.where(free, image, 1.0)
        q = np.arccosh(np.maximum(dirichlet / image, 1.0))  # balance (2)
        p = np.log(image / area)
        with np.errstate(over="ignore"):  # a bad trial step
            value = area * ((1 - self.weight) * self.phi(q) + self.weight * self.phi(p - target))  # balance (3)
        return np.where(free, value, np.inf)

    def area_error(self, x: FloatArray) -> float:
        """Mean of |p - target| over the source's area."""
        area = self.source.area
        return float((area * np.abs(log_areas(self.source, x) - self.target)).sum() / area.sum())

    def phi(self, u: FloatArray) -> FloatArray:
        """u^2, or 2 (cosh u - 1), docs/balance.md (4)."""
        return u * u if self.power == 0 else (2 * np.sinh(u / 2)) ** 2  # balance (4)

    def slopes(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """First and second derivative of phi."""
        if self.power == 0:
            return 2 * u, np.full_like(u, 2.0)
        return 2 * np.sinh(u), 2 * np.cosh(u)


def project(source: Source, x: FloatArray, faces: IntArray | slice = slice(None)) -> tuple[FloatArray, FloatArray]:
    """Signed areas and Dirichlet energies of image faces in planes across their centroids, docs/balance.md (1)."""
    p = x.T[:, source.f[faces].T]  # coordinate, corner, face
    side = p[:, [2, 0, 1]] - p[:, [1, 2, 0]]  # opposite each corner
    outward = p.sum(axis=1)
    length = np.sqrt((outward * outward).sum(axis=0))
    outward /= np.where(length > 0, length, 1.0)
    square = (side * side).sum(axis=0) - (side * outward[:, None]).sum(axis=0) ** 2
    image = 0.5 * (cross(side[:, 2], -side[:, 1]) * outward).sum(axis=0)
    return image, 0.25 * (source.cot[:, faces] * square).sum(axis=0)


def log_areas(source: Source, x: FloatArray) -> FloatArray:
    """Logarithm p of image area over source area by face, of a map free of foldings."""
    return np.asarray(np.log(np.maximum(project(source, x)[0], np.finfo(float).tiny) / source.area))


def cross(u: FloatArray, w: FloatArray) -> FloatArray:
    """Cross products along the first axis."""
    return np.stack((u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]))
