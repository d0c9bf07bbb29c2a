"""The figures of a result in words and numbers, for tables."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .sphere_map import SphereMap


def angle_figures(differences: NDArray[np.float64]) -> dict[str, float]:
    """How the sizes of the angle differences are spread.

    Parameters
    ----------
    differences : (m, 3) float64 array
        Degrees.

    Returns
    -------
    dict
        Mean, median, 95th and 99th percentile, and maximum, in degrees.

    Examples
    --------
    >>> import numpy as np
    >>> angle_figures(np.array([[1.0, -2.0, 3.0]]))["median"]
    2.0
    """
    size = np.abs(differences).ravel()
    median, p95, p99 = np.percentile(size, [50, 95, 99]).tolist()
    return {"mean": float(size.mean()), "median": median, "p95": p95, "p99": p99, "max": float(size.max())}


def result_rows(result: SphereMap) -> list[tuple[str, str]]:
    """What there is to say of a map, as labels and texts.

    Parameters
    ----------
    result : SphereMap
        A map.

    Returns
    -------
    list of (str, str)
        In the order of interest.
    """
    angles = angle_figures(result.angle_differences())
    backend = f", factorised by {result.backend}" if result.backend else ""
    options = ", ".join(f"{key} = {value}" for key, value in result.settings.items())
    rows = [
        ("certificate", str(result.certificate)),
        ("mesh", f"{len(result.vertices):,} vertices, {len(result.faces):,} faces"),
        (
            "angle differences",
            "{mean:.3g} degrees on average, median {median:.3g}, 95% below {p95:.3g}, 99% below {p99:.3g}, "
            "at most {max:.3g}".format(**angles),
        ),
        ("harmonic energy", f"{result.energy:.6f}, which is 4 pi {result.energy - 4 * math.pi:+.2e}"),
        ("method", f"{result.method}{f' ({options})' if options else ''}{backend}"),
        ("run", f"{result.iterations:,} iterations, {result.seconds:.2f} s; {result.status.value}"),
    ]
    return rows + [("note", note) for note in result.notes]
