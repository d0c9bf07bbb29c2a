"""Associated Legendre functions, one degree after another."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def legendre(degree: int, z: FloatArray, s: FloatArray) -> Iterator[FloatArray]:
    """Yield P_l(z) for l = 0 ... degree, s = sqrt(1 - z^2): row m of (l + 1, len(z)), orthonormal, no phase (-1)^m."""
    top = np.full(len(z), np.sqrt(0.25 / np.pi))  # P_ll; s^l underflows where it is below any rounding
    last = before = np.empty((0, len(z)))
    for ell in range(degree + 1):
        if ell:
            top = np.sqrt(1 + 0.5 / ell) * s * top
        m = np.arange(ell)[:, None]
        P = np.empty((ell + 1, len(z)))
        P[ell] = top
        P[:ell] = np.sqrt((4 * ell**2 - 1) / (ell**2 - m**2)) * z * last
        if ell > 1:
            m = m[:-1]
            P[:-2] -= np.sqrt((2 * ell + 1) * ((ell - 1) ** 2 - m**2) / ((2 * ell - 3) * (ell**2 - m**2))) * before
        yield P
        before, last = last, P
