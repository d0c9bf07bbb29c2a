"""The ellipsoid that the coefficients of degree 1 describe, and the four frames that it leaves open."""

from __future__ import annotations

import numpy as np

from ...mesh.arrays import FloatArray

_FLIPS = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])  # of determinant 1


def first_order_frames(c: FloatArray) -> tuple[FloatArray, list[tuple[FloatArray, FloatArray]]]:
    """Half axes along x (middle), y (shortest), z (longest), and pairs of rotations of surface and sphere."""
    M = np.sqrt(0.75 / np.pi) * c[[3, 1, 2]].T  # the point x of the sphere goes to M x: rows are m = -1, 0, 1 (y, z, x)
    U, sizes, Vt = np.linalg.svd(M)
    order = [1, 2, 0]
    surface, sphere = U.T[order], Vt[order]
    # A rotation each: of an ellipsoid turned inside out the shortest axis is mirrored.
    surface[1] *= np.linalg.det(surface)
    sphere[1] *= np.linalg.det(sphere)
    return sizes[order], [(flip[:, None] * surface, flip[:, None] * sphere) for flip in _FLIPS]


def skewness(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Third central moments of the columns over the 3/2 power of the second."""
    w = weights / weights.sum()
    offset = values - w @ values
    return np.asarray(w @ offset**3 / (w @ offset**2) ** 1.5)
