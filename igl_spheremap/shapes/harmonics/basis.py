"""The real orthonormal basis of spherical harmonics: at points, on grids, and the expansion of data over a map.

Row l*l + l + m of the coefficients belongs to Y_lm. A grid has rows of points at equal heights z, each row at equal
steps of longitude from 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from ...mesh.arrays import TINY, FloatArray
from ...resampling.locate import SphereLocator
from ...resampling.transfer import transfer
from ...timings import counted


def legendre(degree: int, z: FloatArray, s: FloatArray) -> Iterator[FloatArray]:
    """Yield P_l(z) for l = 0 ... degree, s = sqrt(1 - z^2): row m of (l + 1, len(z)), orthonormal, no phase (-1)^m.

    By differences D of degrees and by 1 - |z|; z loses half the digits near a pole (docs/shapes.md).
    """
    below_one = s * s / (1 + np.abs(z))
    # P_lm(-z) = (-1)^(l + m) P_lm(z)
    signs = np.stack((np.ones(len(z)), np.where(z < 0, -1.0, 1.0)))
    # P_ll; s^l underflows where it is below any rounding
    top = np.full(len(z), np.sqrt(0.25 / np.pi))
    P = D = np.empty((0, len(z)))
    for ell in range(degree + 1):
        if ell:
            top = np.sqrt(1 + 0.5 / ell) * s * top  # shapes (2)
        m = np.arange(ell)[:, None]
        r = np.sqrt((2 * ell + 1) * (ell - m) / ((2 * ell - 1) * (ell + m)))
        last, step = P, D
        P, D = np.empty((2, ell + 1, len(z)))
        share = r / (ell - m)
        # shapes (3)
        D[:ell] = share * (ell + m - 1) * step - share * (2 * ell - 1) * (below_one * last)
        P[:ell] = r * last + D[:ell]
        P[ell] = D[ell] = top
        yield P * signs[(ell + np.arange(ell + 1)) % 2]


def degree_of(c: FloatArray) -> int:
    """Return the degree L of (L + 1)^2 coefficients."""
    return int(np.sqrt(len(c)) + 0.5) - 1


def rows_of(ell: int) -> slice:
    """Return the rows of one degree, m = -l ... l."""
    return slice(ell * ell, (ell + 1) ** 2)


def terms(c: FloatArray, x: FloatArray) -> Iterator[FloatArray]:
    """Yield the part of each degree at unit rows: Y_l0 = P_l0, Y_lm = sqrt2 P_lm cos(m phi), Y_l,-m with sin(m phi)."""
    s = np.hypot(x[:, 0], x[:, 1])
    # a division by subnormal numbers overflows
    wide = np.where(s < TINY, 2.0**60, 1.0)
    turn = np.where(s > 0, wide * x[:, 0] + 1j * (wide * x[:, 1]), 1)
    turn = np.broadcast_to(turn / np.abs(turn), (degree_of(c), len(x)))
    waves = np.sqrt(2) * np.cumprod(turn, axis=0)  # exp(i m phi), m = 1, 2, ...
    for ell, P in enumerate(legendre(degree_of(c), x[:, 2], s)):
        here, Y = c[rows_of(ell)], P[1:] * waves[:ell]
        # shapes (1)
        yield np.outer(P[0], here[ell]) + Y.real.T @ here[ell + 1 :] + Y.imag.T @ here[:ell][::-1]


def blocks(n: int, rows: int = 1 << 12) -> Iterator[slice]:
    """Divide n rows into slices, so that one degree's functions stay in cache."""
    return (slice(start, start + rows) for start in counted("summing", range(0, n, rows)))


def synthesis(c: FloatArray, x: FloatArray) -> FloatArray:
    """Evaluate the function with coefficients c ((L + 1)^2, k) at unit rows x (n, 3)."""
    values = np.empty((len(x), c.shape[1]))
    for block in blocks(len(x)):
        values[block] = sum(terms(c, x[block]))
    return values


def power(c: FloatArray) -> FloatArray:
    """Sum of the squares of each degree's coefficients; no rotation changes it."""
    return np.array([(c[rows_of(ell)] ** 2).sum() for ell in range(degree_of(c) + 1)])


@lru_cache(maxsize=32)
def gauss_rows(n: int) -> tuple[FloatArray, FloatArray]:
    """Heights from north to south, and weights of sum 2, exact for polynomials in z of degree 2 n - 1.

    On the colatitude Newton's method keeps the digits near the poles that it loses on z: two of them at 200 rows.
    """
    # off by O(n^-2) of their distance: Newton doubles the digits
    theta = np.pi * (np.arange(n) + 0.75) / (n + 0.5)
    for _ in range(4):
        z = np.cos(theta)
        last, P = np.ones(n), z
        for ell in range(1, n):
            last, P = P, ((2 * ell + 1) * z * P - ell * last) / (ell + 1)
        slope = n * (z * P - last) / np.sin(theta)  # dP_n / dtheta
        theta = theta - P / slope
    z, w = np.cos(theta), 2 / slope**2
    z.flags.writeable = w.flags.writeable = False  # the cache returns them again
    return z, w


def grid_points(z: FloatArray, phi: FloatArray) -> FloatArray:
    """(rows, columns, 3) points of the sphere at heights z and longitudes phi."""
    s = np.sqrt((1 - z) * (1 + z))[:, None]
    return np.stack(np.broadcast_arrays(s * np.cos(phi), s * np.sin(phi), z[:, None]), axis=-1)


def longitudes(n: int) -> FloatArray:
    """Return n longitudes at equal steps from 0, in radians."""
    return 2 * np.pi * np.arange(n) / n


def analysis(values: FloatArray, z: FloatArray, w: FloatArray, degree: int) -> FloatArray:
    """Coefficients ((L + 1)^2, k) of values (rows, columns, k); exact for functions of degree L, as w and z are.

    Columns must be more than twice the degree.
    """
    n, k = values.shape[1:]
    # m, z, k
    F = np.fft.rfft(values, axis=1)[:, : degree + 1].transpose(1, 0, 2) * (
        2 * np.pi / n * w[:, None]
    )
    F[1:] *= np.sqrt(2)
    waves = np.concatenate((F.real, -F.imag), axis=2)
    c = np.empty(((degree + 1) ** 2, k))
    for ell, P in enumerate(legendre(degree, z, np.sqrt((1 - z) * (1 + z)))):
        each = np.matmul(P[:, None], waves[: ell + 1])[:, 0]  # shapes (4): m, 2 k
        middle = ell * ell + ell
        c[middle : middle + ell + 1] = each[:, :k]
        c[middle - ell : middle] = each[:0:-1, k:]
    return c


def expand(
    locator: SphereLocator, values: FloatArray, degree: int, oversampling: float
) -> FloatArray:
    """Coefficients ((L + 1)^2, k) of the piecewise linear function with these values (n, k) at the vertices.

    Sums over vertices, or least squares, are off by orders of magnitude more where vertices crowd: see docs/shapes.md.
    """
    n = math.ceil(oversampling * degree) + 2
    z, w = gauss_rows(n)
    points = grid_points(z, longitudes(2 * n)).reshape(-1, 3)
    return analysis(transfer(locator, values, points).reshape(n, 2 * n, -1), z, w, degree)
