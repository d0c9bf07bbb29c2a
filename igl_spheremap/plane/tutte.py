"""Tutte's map of a disk: the boundary on a convex curve, every other vertex at the weighted mean of its neighbours."""

from __future__ import annotations

import igl
import numpy as np

from ..mesh.arrays import FloatArray
from ..mesh.disk import Disk
from ..operators.factor.factorize import factorize
from ..operators.laplacian import mollified_edge_lengths, summed_laplacian

#: Boundary edges count as no shorter than this share of their mean, and weights are bounded by 1 and its inverse.
_LEAST = 1e-3


def tutte_map(disk: Disk, weights: str = "uniform") -> FloatArray:
    """Images (n, 2) in the unit disk, without foldings but for rounding: all weights are positive.

    The boundary is divided by the lengths of its edges. Tutte 1963, *How to Draw a Graph*.
    """
    n, ring = len(disk.v), disk.v[disk.rim]
    lengths = np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1)
    lengths = np.maximum(lengths, _LEAST * lengths.mean())
    turn = 2 * np.pi * (np.cumsum(lengths) - lengths) / lengths.sum()
    p = np.zeros((n, 2))
    p[disk.rim] = np.column_stack((np.cos(turn), np.sin(turn)))
    inner = np.ones(n, dtype=bool)
    inner[disk.rim] = False
    if inner.any():
        weight = np.full(disk.f.shape, 0.5)
        if weights != "uniform":
            weight = np.clip(igl.cotmatrix_entries(mollified_edge_lengths(disk.v, disk.f)), _LEAST, 1 / _LEAST)
        L = summed_laplacian(weight, disk.f, n)
        p[inner] = factorize(L[inner][:, inner]).solve(-(L[inner][:, ~inner] @ p[~inner]))
    return p
