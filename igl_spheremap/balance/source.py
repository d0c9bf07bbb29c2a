"""The source's triangles laid flat: areas, cotangents, and gradients of the hat functions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..mesh.arrays import ComplexArray, FloatArray, IntArray
from ..operators.laplacian import mollified_edge_lengths


@dataclass(frozen=True, eq=False)
class Source:
    """What the energies read of a mesh; its area is 4 pi, that of the unit sphere.

    Attributes
    ----------
    f : (m, 3) int64 array
        Faces.
    n : int
        Number of vertices.
    area : (m,) float64 array
        Areas of the faces, none zero.
    cot : (3, m) float64 array
        Cotangents of the corner angles.
    hats : (3, m) complex128 array
        Gradient of each corner's hat function in the plane of the face.
    """

    f: IntArray
    n: int
    area: FloatArray
    cot: FloatArray
    hats: ComplexArray


def lay_flat(v: FloatArray, f: IntArray) -> Source:
    """Lay every face flat by its edge lengths, mollified so that no area is zero."""
    lengths = np.asarray(mollified_edge_lengths(v, f))
    area = _heron(lengths)
    scale = np.sqrt(4 * np.pi / area.sum())
    a, b, c = (lengths * scale).T  # opposite corners 0, 1 and 2
    area = area * scale**2
    cot = np.stack((b * b + c * c - a * a, c * c + a * a - b * b, a * a + b * b - c * c)) / (4 * area)
    # Corner 0 lies at the origin, corner 1 at (c, 0), corner 2 at (c, 2 area) cut by the cotangent of corner 0.
    second = 1j * c / (2 * area)
    first = (1 - 1j * cot[0]) / c
    return Source(f, len(v), area, cot, np.stack((-(first + second), first, second)))


def _heron(lengths: FloatArray) -> FloatArray:
    """Areas by Kahan's stable form of Heron's formula."""
    c, b, a = np.sort(lengths, axis=1).T
    return 0.25 * np.sqrt((a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c)))
