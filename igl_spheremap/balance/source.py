"""The source's triangles laid flat: areas, cotangents, and gradients of the hat functions."""

from __future__ import annotations

from dataclasses import dataclass

import igl
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
    area = np.asarray(igl.doublearea(l=lengths, nan_replacement=0.0)) / 2
    scale = np.sqrt(4 * np.pi / area.sum())
    c = lengths[:, 2] * scale  # between corners 0 and 1
    area = area * scale**2
    cot = 2 * np.asarray(igl.cotmatrix_entries(l=lengths)).T
    # Corner 0 lies at the origin, corner 1 at (c, 0), corner 2 at h (cot_0, 1) with h = 2 area / c.
    second = 1j * c / (2 * area)
    first = (1 - 1j * cot[0]) / c
    return Source(f, len(v), area, cot, np.stack((-(first + second), first, second)))
