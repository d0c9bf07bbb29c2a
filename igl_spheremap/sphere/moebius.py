"""Moebius maps of the sphere, and the one that balances given weights."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError
from ..mesh.arrays import FloatArray
from .rows import row_dots, weighted_moment, weighted_sum

_EPS = np.finfo(float).eps
#: Squared length beyond which a Moebius centre is at the rim of the ball, to rounding.
_RIM = 1 - 512 * _EPS
#: Length of the weighted mean at which weights count as balanced, and Newton steps at the most: 12 were the most seen.
_BALANCED, _STEPS = 1e-12, 50
#: Newton steps shorter than this are rounding; as a shift it keeps the Hessian regular.
_ROUNDING = 1e-14


def moebius(x: FloatArray, c: ArrayLike) -> FloatArray:
    """Apply to unit rows the Moebius map of the ball that takes `c`, a point inside it, to the centre.

    The points near c / |c| are spread out. Raises MeshError for a `c` that is not inside the unit ball.

    >>> moebius(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]), [0.0, 0.0, 0.5]).round(12)
    array([[ 0. ,  0. ,  1. ],
           [ 0.6,  0. , -0.8]])
    """
    c = np.asarray(c, dtype=np.float64)
    cc = float(c @ c)
    if not cc < 1:
        raise MeshError(f"the Moebius centre has length {np.sqrt(cc):g}; give a point inside the unit ball")
    y = x - c
    y *= ((1 - cc) / row_dots(y, y))[:, None]  # algorithm (18)
    y -= c
    # Where c is near the rim, rounding leaves the sphere by some units in the last place: normalise.
    y /= np.sqrt(row_dots(y, y))[:, None]
    return y


def conformal_barycentre(x: FloatArray, weights: FloatArray) -> FloatArray:
    """Point of the ball whose Moebius map to the centre balances non-negative weights at unit rows.

    It is unique (Douady and Earle 1986; Baden, Crane, Kazhdan 2018, *Moebius Registration*) unless half of the weight
    or more is at one point: then there is none, and the search ends near the rim.

    >>> x = np.vstack((np.eye(3), -np.eye(3)))
    >>> moved = moebius(x, [0.1, 0.2, 0.3])
    >>> c = conformal_barycentre(moved, np.ones(6))
    >>> bool(np.abs(moebius(moved, c).mean(axis=0)).max() < 1e-9)
    True
    """
    return _balance(x, weights)[0]


def _balance(x: FloatArray, weights: FloatArray, within: float = _BALANCED) -> tuple[FloatArray, FloatArray]:
    """The conformal barycentre, and the map that it centres."""
    w = weights / weights.sum()
    centre, y, mean = np.zeros(3), x, weighted_sum(w, x)
    for _ in range(_STEPS):
        size = float(np.linalg.norm(mean))
        if size <= within:
            break
        # Newton on the convex energy of the hyperbolic ball, whose gradient is the mean of the moved points.
        hessian = 2 * (np.eye(3) - weighted_moment(w, y, y)) + _ROUNDING * np.eye(3)  # algorithm (19)
        step: FloatArray = np.asarray(np.linalg.solve(hessian, mean), dtype=np.float64)
        length = float(np.linalg.norm(step))
        if length > 0.5:
            step = step * (np.tanh(min(length, 2.0)) / length)  # the ball ends at 1
        while True:
            trial = _compose(centre, step)
            if trial @ trial > _RIM:
                return centre, y
            moved = moebius(x, trial)
            moved_mean = weighted_sum(w, moved)
            if float(np.linalg.norm(moved_mean)) < size or length < _ROUNDING:
                break
            step, length = step / 2, length / 2
        centre, y, mean = trial, moved, moved_mean
        if length < _ROUNDING:
            break
    return centre, y


def _compose(first: FloatArray, then: FloatArray) -> FloatArray:
    """Point that goes to the centre under ``moebius(moebius(., first), then)``."""
    # The inverse of the first map, taken at `then`: hyperbolic translation of `then` by `first`.
    dot, ff, tt = float(first @ then), float(first @ first), float(then @ then)
    return ((1 + 2 * dot + tt) * first + (1 - ff) * then) / (1 + 2 * dot + ff * tt)  # algorithm (20)


def center(x: FloatArray, weights: FloatArray, within: float = _BALANCED) -> FloatArray:
    """Moebius map of `x` for which `weights` have their barycentre at the origin, or `within` a distance from it.

    It is computed in one step from `x`, so that rounding does not add up; `x` itself if it is centred already.

    >>> x = moebius(np.vstack((np.eye(3), -np.eye(3))), [0.5, 0, 0])
    >>> bool(np.abs(center(x, np.ones(6)).sum(axis=0)).max() < 1e-9)
    True
    """
    return _balance(x, weights, within)[1]
