"""Statistics of distortions, for tables and in words."""

from __future__ import annotations

import numpy as np

from ..mesh.arrays import FloatArray


def log_figures(ratios: FloatArray) -> dict[str, float]:
    """Mean, 99th percentile and maximum of the sizes of logarithms of ratios, those of zero areas left out.

    NaN if all are left out.

    >>> log_figures(np.array([0.5, -1.5, np.inf]))["mean"]
    1.0
    """
    finite = ratios[np.isfinite(ratios)]
    size = np.abs(finite) if len(finite) else np.full(1, np.nan)
    return {"mean": float(size.mean()), "p99": float(np.percentile(size, 99)), "max": float(size.max())}


def angle_figures(differences: FloatArray) -> dict[str, float]:
    """Mean, median, 95th and 99th percentile and maximum of the sizes of angle differences, in their units.

    >>> angle_figures(np.array([[1.0, -2.0, 3.0]]))["median"]
    2.0
    """
    size = np.abs(differences).ravel()
    median, p95, p99 = np.percentile(size, [50, 95, 99]).tolist()
    return {"mean": float(size.mean()), "median": median, "p95": p95, "p99": p99, "max": float(size.max())}


def describe_angles(figures: dict[str, float]) -> str:
    """The statistics of `angle_figures` in words."""
    return ("{mean:.3g} degrees on average (median {median:.3g}, 95% below {p95:.3g}, 99% below {p99:.3g}, "
            "at most {max:.3g})").format(**figures)


def describe_logs(figures: dict[str, float]) -> str:
    """The statistics of `log_figures` in words."""
    return "{mean:.3g} on average (99% below {p99:.3g}, at most {max:.3g})".format(**figures)
