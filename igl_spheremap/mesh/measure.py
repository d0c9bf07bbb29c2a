"""Angles and areas of triangles in space."""

from __future__ import annotations

import igl
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def unit_scale(d: FloatArray) -> FloatArray:
    """Rows divided by their largest entry, so that products neither over- nor underflow."""
    size = np.abs(d).max(axis=1, keepdims=True)
    return np.asarray(d / np.where(size > 0, size, 1))


def corner_angles(v: FloatArray, f: IntArray) -> FloatArray:
    """Corner angles in radians, by libigl, and by a slower way where libigl's fails on a degenerate face.

    Parameters
    ----------
    v : (n, 3) float64 array
        Finite positions.
    f : (m, 3) int64 array
        Faces in range.

    Returns
    -------
    (m, 3) float64 array
        Between 0 and pi, always finite; a corner with a zero-length side counts as 0.

    Examples
    --------
    >>> import numpy as np
    >>> np.degrees(corner_angles(np.eye(3), np.array([[0, 1, 2]]))).round(9)
    array([[60., 60., 60.]])
    """
    angles = np.asarray(igl.internal_angles(v, f))
    # The law of cosines loses the thin corners first: below 1e-4 radians or where it gave no number, use atan2.
    redo = np.flatnonzero(~(angles.min(axis=1) > 1e-4))
    for k in range(3):
        a, b, c = (v[f[redo, (k + j) % 3]] for j in range(3))
        u, w = unit_scale(b - a), unit_scale(c - a)
        angles[redo, k] = np.arctan2(np.linalg.norm(np.cross(u, w), axis=1), np.einsum("ij,ij->i", u, w))
    return angles


def face_areas(v: FloatArray, f: IntArray) -> FloatArray:
    """Flat areas of the faces.

    Parameters
    ----------
    v : (n, 3) float64 array
        Finite positions.
    f : (m, 3) int64 array
        Faces in range.

    Returns
    -------
    (m,) float64 array
        Non-negative.

    Examples
    --------
    >>> import numpy as np
    >>> face_areas(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=float), np.array([[0, 1, 2]]))
    array([0.5])
    """
    return np.asarray(igl.doublearea(v, f)) / 2

