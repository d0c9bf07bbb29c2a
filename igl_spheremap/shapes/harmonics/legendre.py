"""Associated Legendre functions, one degree after another."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...mesh.arrays import FloatArray


def legendre(degree: int, z: FloatArray, s: FloatArray) -> Iterator[FloatArray]:
    """Yield P_l(z) for l = 0 ... degree, s = sqrt(1 - z^2): row m of (l + 1, len(z)), orthonormal, no phase (-1)^m.

    By differences D of degrees and by 1 - |z|, not by z, which near a pole loses half the digits (docs/shapes.md).
    """
    below_one = s * s / (1 + np.abs(z))
    signs = np.stack((np.ones(len(z)), np.where(z < 0, -1.0, 1.0)))  # P_lm(-z) = (-1)^(l + m) P_lm(z)
    top = np.full(len(z), np.sqrt(0.25 / np.pi))  # P_ll; s^l underflows where it is below any rounding
    P = D = np.empty((0, len(z)))
    for ell in range(degree + 1):
        if ell:
            top = np.sqrt(1 + 0.5 / ell) * s * top  # (2)
        m = np.arange(ell)[:, None]
        r = np.sqrt((2 * ell + 1) * (ell - m) / ((2 * ell - 1) * (ell + m))) if ell else m
        last, step = P, D
        P, D = np.empty((2, ell + 1, len(z)))
        D[:ell] = r / (ell - m) * (ell + m - 1) * step - r / (ell - m) * (2 * ell - 1) * (below_one * last)  # (3)
        P[:ell] = r * last + D[:ell]
        P[ell] = D[ell] = top
        yield P * signs[(ell + np.arange(ell + 1)) % 2]
