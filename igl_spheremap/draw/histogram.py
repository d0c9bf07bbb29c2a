"""The histogram of angle differences that every picture shows."""

from __future__ import annotations

import numpy as np

from ..mesh.arrays import FloatArray

_BINS = 81


def angle_histogram(differences: FloatArray, reach: float) -> tuple[FloatArray, FloatArray]:
    """Edges of bins from `-reach` to `reach` degrees, and the share of the differences in each.

    The first and the last bin also hold what is beyond.

    >>> edges, share = angle_histogram(np.array([[0.0, 0.0, 90.0]]), 40.0)
    >>> edges[[0, -1]].tolist(), share[[40, -1]].round(3).tolist()
    ([-40.0, 40.0], [0.667, 0.333])
    """
    counts, edges = np.histogram(np.clip(differences, -reach, reach), bins=_BINS, range=(-reach, reach))
    return edges, counts / differences.size
