"""Geometry of the unit sphere: tangents, the Cayley update, Moebius maps, centring, rotation."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import MeshError
from .rows import row_dots, weighted_moment, weighted_sum

FloatArray = NDArray[np.float64]

#: Squared length beyond which a Moebius centre is at the rim of the ball, to rounding.
_RIM = 1 - 1e-13


def moebius(x: FloatArray, c: ArrayLike) -> FloatArray:
    """Apply to points of the sphere the Moebius map of the ball that takes `c` to the centre.

    Parameters
    ----------
    x : (n, 3) float64 array
        Unit rows.
    c : (3,) array_like
        A point inside the unit ball.

    Returns
    -------
    (n, 3) float64 array
        Unit rows; the points near c / |c| are spread out.

    Raises
    ------
    MeshError
        If `c` is not inside the unit ball.

    Examples
    --------
    >>> import numpy as np
    >>> moebius(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]), [0.0, 0.0, 0.5]).round(12)
    array([[ 0. ,  0. ,  1. ],
           [ 0.6,  0. , -0.8]])
    """
    c = np.asarray(c, dtype=np.float64)
    cc = float(c @ c)
    if not cc < 1:
        raise MeshError(f"the Moebius centre has length {np.sqrt(cc):g}; give a point inside the unit ball")
    y = x - c
    y *= ((1 - cc) / row_dots(y, y))[:, None]
    y -= c
    # The rounding of a strong boost leaves the sphere by a few ulp: put it back.
    y /= np.sqrt(row_dots(y, y))[:, None]
    return y


def conformal_barycentre(x: FloatArray, weights: FloatArray, tolerance: float = 1e-12) -> FloatArray:
    """Point of the ball that a Moebius map must take to the centre for `weights` to balance.

    Parameters
    ----------
    x : (n, 3) float64 array
        Unit rows.
    weights : (n,) float64 array
        Non-negative weights with a positive sum, less than half of it at any one point: else there is no barycentre,
        and the search ends near the rim.
    tolerance : float
        Length of the weighted mean at which the search ends.

    Returns
    -------
    (3,) float64 array
        The conformal barycentre c: the mean of ``moebius(x, c)`` vanishes. It is unique.

    References
    ----------
    Douady and Earle 1986; Baden, Crane, Kazhdan 2018, Moebius Registration.

    Examples
    --------
    >>> import numpy as np
    >>> x = np.vstack((np.eye(3), -np.eye(3)))
    >>> moved = moebius(x, [0.1, 0.2, 0.3])
    >>> c = conformal_barycentre(moved, np.ones(6))
    >>> bool(np.abs(moebius(moved, c).mean(axis=0)).max() < 1e-9)
    True
    """
    w = weights / weights.sum()
    centre = np.zeros(3)
    y = x
    for _ in range(50):
        mean = weighted_sum(w, y)
        size = float(np.linalg.norm(mean))
        if size <= tolerance:
            break
        # Newton on the convex energy of the hyperbolic ball, whose gradient is the mean of the moved points.
        hessian = 2 * (np.eye(3) - weighted_moment(w, y, y)) + 1e-14 * np.eye(3)
        step: FloatArray = np.asarray(np.linalg.solve(hessian, mean), dtype=np.float64)
        length = float(np.linalg.norm(step))
        if length > 0.5:
            step = step * (np.tanh(min(length, 2.0)) / length)  # the ball ends at 1
        while True:
            trial = _compose(centre, step)
            if trial @ trial > _RIM:
                return centre
            moved = moebius(x, trial)
            if float(np.linalg.norm(weighted_sum(w, moved))) < size or length < 1e-14:
                break
            step, length = step / 2, length / 2
        centre, y = trial, moved
        if length < 1e-14:
            break
    return centre


def _compose(first: FloatArray, then: FloatArray) -> FloatArray:
    """Point that goes to the centre under ``moebius(moebius(., first), then)``."""
    # The inverse of the first map, taken at `then`: hyperbolic translation of `then` by `first`.
    dot, ff, tt = float(first @ then), float(first @ first), float(then @ then)
    return ((1 + 2 * dot + tt) * first + (1 - ff) * then) / (1 + 2 * dot + ff * tt)


def center(x: FloatArray, weights: FloatArray) -> FloatArray:
    """Moebius map of `x` for which `weights` have their barycentre at the origin.

    Parameters
    ----------
    x : (n, 3) float64 array
        Unit rows.
    weights : (n,) float64 array
        Non-negative; the vertex areas of the source in this package.

    Returns
    -------
    (n, 3) float64 array
        Unit rows. Computed in one step from `x`, so that rounding does not add up.

    Examples
    --------
    >>> import numpy as np
    >>> x = moebius(np.vstack((np.eye(3), -np.eye(3))), [0.5, 0, 0])
    >>> bool(np.abs(center(x, np.ones(6)).sum(axis=0)).max() < 1e-9)
    True
    """
    return moebius(x, conformal_barycentre(x, weights))


