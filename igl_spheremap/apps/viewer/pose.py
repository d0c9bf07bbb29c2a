"""The pose of a surface before the camera."""

from __future__ import annotations

import numpy as np

from ...mesh.arrays import FloatArray
from .choices import UPS

_AZIMUTH, _ELEVATION = np.radians(28), np.radians(16)


def pose(v: FloatArray, up: str = "z") -> FloatArray:
    """Rotation whose rows are right, up and towards the viewer: the broad side in front, seen from above and aside.

    `up` is one of `UPS`.

    >>> box = np.array([[0.0, 0, 0], [9, 0, 0], [9, 2, 0], [9, 2, 5]])
    >>> rotation = pose(box, "z")
    >>> bool(rotation[0] @ [1, 0, 0] > 0.8), bool(rotation[1] @ [0, 0, 1] > 0.9)
    (True, True)
    """
    if up not in UPS:
        raise ValueError(f"unknown direction {up!r}: choose one of {', '.join(UPS)}")
    vertical = np.array(UPS[up], dtype=np.float64)
    level = np.flatnonzero(vertical == 0)
    extent = np.ptp(v, axis=0)
    right = np.zeros(3)
    right[level[int(np.argmax(extent[level] * [1.0001, 1.0]))]] = 1.0  # of equal extents the first
    front = np.cross(right, vertical)
    axes = np.vstack((right, vertical, front))
    a, e = _AZIMUTH, _ELEVATION
    aside = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
    above = np.array([[1, 0, 0], [0, np.cos(e), -np.sin(e)], [0, np.sin(e), np.cos(e)]])
    return above @ aside @ axes


def fit(v: FloatArray, rotation: FloatArray) -> FloatArray:
    """Rotate a surface, and scale it about the middle of its bounding box to the unit ball."""
    w = v @ rotation.T
    w = w - (w.max(axis=0) + w.min(axis=0)) / 2
    return np.asarray(w / max(float(np.linalg.norm(w, axis=1).max()), 1e-300))
