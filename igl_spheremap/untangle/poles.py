"""A gauge for bodies beyond float64: the two deepest tips at (0, 0, 1) and (0, 0, -1).

Near these points the first two coordinates are small numbers of full relative precision, down to 1e-100 and
less, where elsewhere positions are multiples of 1e-16. Limbs that lead to the two tips need not be stretched
there.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..operators.factor import Factor
from ..sphere.charts import from_chart, to_chart
from ..sphere.rows import row_dots
from .depth import predicted_log_edges
from .nested import Limbs, solve_limbs

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def poles_gauge(x: FloatArray, tips: tuple[int, int], area: FloatArray) -> FloatArray:
    """Moebius map of `x` with two vertices at the poles and as much area in the north as in the south.

    Parameters
    ----------
    x : (n, 3) float64 array
        Unit rows.
    tips : tuple of int
        Vertices to go to (0, 0, 1) and (0, 0, -1).
    area : (n,) float64 array
        Vertex areas, which are to balance along the axis.

    Returns
    -------
    (n, 3) float64 array
        Unit rows; those of the tips exact.
    """
    north, south = tips
    z = to_chart(x, -x[[north]])
    z -= z[south]
    distance = np.log(np.maximum(np.abs(z) / 2, 1e-300))
    low, high = -distance.max(), -distance.min()
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (low, middle) if area @ np.tanh(distance + middle) > 0 else (middle, high)
    y = from_chart(z * np.exp(low), np.array([[0.0, 0.0, -1.0]]))
    y[north], y[south] = (0, 0, 1), (0, 0, -1)
    return y


def poles_limbs(v: FloatArray, f: IntArray, x: FloatArray, L: sp.csr_matrix, factor: Factor,
               area: FloatArray) -> tuple[FloatArray, Limbs]:
    """Put the tips of the two deepest limbs at the poles, and solve all limbs there.

    Parameters
    ----------
    v : (n, 3) float64 array
        Source.
    f : (m, 3) int64 array
        Faces.
    x : (n, 3) float64 array
        A map with its limbs solved as well as its gauge allows.
    L : (n, n) sparse matrix
        Laplacian.
    factor : Factor
        Its inverse.
    area : (n,) float64 array
        Vertex areas.

    Returns
    -------
    x : (n, 3) float64 array
        Unit rows.
    limbs : Limbs
        Where they lie.

    Raises
    ------
    FactorisationFailed
        If the map means too little for limbs to be solved around it.
    """
    depth = -predicted_log_edges(v, f, x, factor, area)
    tips = _tips(x, depth)
    x = poles_gauge(x, tips, area)
    depth = -predicted_log_edges(v, f, x, factor, area)
    limbs = solve_limbs(x, L, depth, area, tips)
    return limbs.onto_sphere(x, tips), limbs


def _tips(x: FloatArray, depth: FloatArray) -> tuple[int, int]:
    """The deepest vertex, and the deepest one that is not near it in the image."""
    first = int(np.argmax(depth))
    away = row_dots(x - x[first], x - x[first]) > 1e-6
    return first, int(np.argmax(np.where(away, depth, -np.inf)))
