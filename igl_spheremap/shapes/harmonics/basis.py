"""The real orthonormal basis at points of the sphere. Row l*l + l + m of the coefficients belongs to Y_lm."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...mesh.arrays import FloatArray
from .legendre import legendre

_BLOCK = 1 << 12  # points at once, so that one degree's functions stay in cache


def degree_of(c: FloatArray) -> int:
    """The degree L of (L + 1)^2 coefficients."""
    return int(np.sqrt(len(c)) + 0.5) - 1


def rows_of(ell: int) -> slice:
    """The rows of one degree, m = -l ... l."""
    return slice(ell * ell, (ell + 1) ** 2)


def terms(c: FloatArray, x: FloatArray) -> Iterator[FloatArray]:
    """Yield the part of each degree at unit rows: Y_l0 = P_l0, Y_lm = sqrt2 P_lm cos(m phi), Y_l,-m with sin(m phi)."""
    s = np.hypot(x[:, 0], x[:, 1])
    turn = np.where(s > 0, x[:, 0] + 1j * x[:, 1], 1)
    turn = np.broadcast_to(turn / np.abs(turn), (degree_of(c), len(x)))
    waves = np.sqrt(2) * np.cumprod(turn, axis=0)  # exp(i m phi), m = 1, 2, ...
    for ell, P in enumerate(legendre(degree_of(c), x[:, 2], s)):
        here, Y = c[rows_of(ell)], P[1:] * waves[:ell]
        yield np.outer(P[0], here[ell]) + Y.real.T @ here[ell + 1 :] + Y.imag.T @ here[:ell][::-1]


def blocks(n: int) -> Iterator[slice]:
    """Slices that cover n rows."""
    return (slice(start, start + _BLOCK) for start in range(0, n, _BLOCK))


def synthesis(c: FloatArray, x: FloatArray) -> FloatArray:
    """Values of the function with coefficients c ((L + 1)^2, k) at unit rows x (n, 3)."""
    values = np.empty((len(x), c.shape[1]))
    for block in blocks(len(x)):
        values[block] = sum(terms(c, x[block]))
    return values


def power(c: FloatArray) -> FloatArray:
    """Sum of the squares of each degree's coefficients; no rotation changes it."""
    return np.array([(c[rows_of(ell)] ** 2).sum() for ell in range(degree_of(c) + 1)])
