"""Which maps of a population stand out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..mesh.arrays import FloatArray
from .table import MAPPED, Row

#: Figures that are the worse the larger they are, with their labels.
FIGURES = {
    "mean_angle": "mean angle", "p99_angle": "99% angle", "max_angle": "max angle",
    "mean_area": "mean log area", "p99_area": "99% log area", "max_area": "max log area",
    "mean_edge": "mean log edge", "stretch": "stretch",
}  # fmt: skip
#: Tukey's outer fence: interquartile ranges above the third quartile.
OUTLIER = 3.0


def excess(rows: Sequence[Row]) -> FloatArray:
    """How far the figures (rows, `FIGURES`) lie above the third quartile, in interquartile ranges.

    NaN counts as 0, and where the range is 0, all that is above it is infinitely far.

    >>> excess([Row("", "", mean_angle=angle) for angle in (1, 2, 3, 4, 5, 20)])[:, 0].round(1).tolist()
    [-1.5, -1.1, -0.7, -0.3, 0.1, 6.1]
    """
    columns = np.array([[getattr(row, name) for row in rows] for name in FIGURES], dtype=np.float64)
    beyond = np.zeros((len(rows), len(FIGURES)))
    for k, column in enumerate(columns):
        finite = column[np.isfinite(column)]
        if len(finite):
            low, high = np.percentile(finite, [25, 75])
            with np.errstate(divide="ignore", invalid="ignore"):
                beyond[:, k] = np.nan_to_num((column - high) / (high - low), posinf=np.inf, neginf=-np.inf)
    return beyond


def worst_first(rows: Sequence[Row]) -> list[int]:
    """Indices of rows: those without a map, those with foldings, then by the largest excess of a figure."""
    beyond = excess(rows).max(axis=1, initial=-np.inf)
    mapless = [row.status not in MAPPED for row in rows]
    return sorted(range(len(rows)), key=lambda k: (not mapless[k], -rows[k].foldings, -beyond[k]))
