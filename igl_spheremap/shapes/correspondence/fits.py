"""Fits of one surface's features to another's: by a Moebius map, and as a term of second-order steps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from ...mesh.arrays import HALF_DIGITS, FloatArray, IntArray
from ...sphere.moebius import moebius
from ...verify.signs import folded_faces

#: Values (n, k) and gradients (n, k, 3) at points of the sphere.
SphereFunction = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
#: Takes each iterate and its cost.
IterateListener = Callable[[FloatArray, float], None]


def fit_moebius(
    x: FloatArray,
    f: IntArray,
    weights: FloatArray,
    features: FloatArray,
    target: SphereFunction,
    listener: IterateListener,
    ridge: float = 1e-3,
    least_gain: float = 1e-7,
    steps: int = 30,
) -> FloatArray:
    """Lower the weighted square of features - target(m(x)) over Moebius maps m, and return the best m(x).

    The features (n, k) have unit variance, the weights sum 1. A `ridge` on the square of the boost keeps boosts short
    that features leave open. The fit ends at a gain of the share `least_gain`. A step that folds a face is shortened:
    the map moves vertices, not edges, and slivers can flip.
    """
    # takes .2 s, which registrations by rotation don't need
    from scipy.optimize import least_squares

    root = np.sqrt(weights)[:, None]
    last: tuple[FloatArray, FloatArray, FloatArray]
    found = x

    def residuals(t: FloatArray) -> FloatArray:
        nonlocal last
        y = x  # a move by nothing may fold slivers, by rounding
        if t.any():
            y = _moved(x, t)
        values, gradients = target(y)
        last = y, root * (features - values), gradients  # shapes (8)
        if folded_faces(y, f).any():
            return np.full(features.size + 3, np.inf)
        return np.append(last[1], np.sqrt(ridge) * t[3:])

    def jacobian(t: FloatArray) -> FloatArray:
        """Return derivatives at the last map tried, which was accepted, and report it."""
        nonlocal found
        y, off, gradients = last  # of the map that was accepted, the last one tried
        if t.any():
            found = y
            listener(y, float((off * off).sum()))
        J = np.zeros((features.size + 3, 6))
        for k, h in enumerate(HALF_DIGITS * np.eye(6)):
            J[:-3, k] = -(
                root * np.einsum("nki,ni->nk", gradients, (_moved(x, t + h) - y) / HALF_DIGITS)
            ).ravel()
        J[-3:, 3:] = np.sqrt(ridge) * np.eye(3)
        return J

    least_squares(residuals, np.zeros(6), jacobian, ftol=least_gain, max_nfev=steps + 1)
    return found


def _moved(x: FloatArray, t: FloatArray) -> FloatArray:
    """Boost x by the last three entries of t, then rotate it by the first three."""
    length, share = float(np.linalg.norm(t[3:])), 0.5
    if length:
        share = np.tanh(length / 2) / length
    centre = -t[3:] * share
    return moebius(x, centre) @ Rotation.from_rotvec(t[:3]).as_matrix().T


class Misfit:
    """Half the weighted sum of squares of features - target(x), with the Hessian of Gauss and Newton.

    Features are any values at the vertices; `target` gives the values (n, k) and gradients (n, k, 3) to compare with.
    """

    def __init__(self, weights: FloatArray, features: FloatArray, target: SphereFunction) -> None:
        self._weights, self._features, self._target = weights, features, target
        self._last: tuple[FloatArray, FloatArray, FloatArray] | None = None

    def value(self, x: FloatArray) -> float:
        """Half the weighted sum of squares."""
        off = self._off(x)[0]
        return float(np.einsum("n,nk,nk->", self._weights, off, off)) / 2

    def derivatives(self, x: FloatArray, axes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gradient (2, n) and vertices' blocks (2, 2, n) along the axes."""
        off, gradients = self._off(x)
        slopes = np.einsum("nkd,adn->akn", gradients, axes)
        return (
            -np.einsum("n,akn,nk->an", self._weights, slopes, off),
            np.einsum("n,akn,bkn->abn", self._weights, slopes, slopes),
        )

    def _off(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Compute differences (n, k) and gradients (n, k, 3) at a map, and keep them for the next call."""
        if self._last is None or self._last[0] is not x:
            values, gradients = self._target(x)
            self._last = x, self._features - values, gradients
        return self._last[1:]
