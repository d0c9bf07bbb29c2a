"""Colours for numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


# Dark blue to yellow through green, nearly even in lightness: five colours of matplotlib's viridis.
_COLOURS = np.array([[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]], dtype=float)


def colours(values: FloatArray) -> dict[str, NDArray[np.uint8]]:
    """Colours for a scalar map, from its 1st to its 99th percentile.

    Parameters
    ----------
    values : (n,) float64 array
        The map; what is not finite is shown as an end of the scale.

    Returns
    -------
    dict of (n,) uint8 arrays
        ``red``, ``green`` and ``blue``, as PLY files name them.

    Examples
    --------
    >>> colours(np.array([0.0, 1.0]))["red"].tolist()
    [68, 253]
    """
    finite = values[np.isfinite(values)]
    low, high = np.percentile(finite, [1, 99]) if len(finite) else (0.0, 1.0)
    place = np.nan_to_num((values - low) / (high - low if high > low else 1.0), posinf=1.0, neginf=0.0)
    knots = np.linspace(0, 1, len(_COLOURS))
    return {
        name: np.interp(place, knots, _COLOURS[:, k]).astype(np.uint8)
        for k, name in enumerate(("red", "green", "blue"))
    }

