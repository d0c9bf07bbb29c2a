"""Spherical harmonics on grids: rows of points at equal heights z, each row at equal steps of longitude from 0."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ...mesh.arrays import FloatArray
from ..locate import SphereLocator
from ..transfer import transfer
from .basis import degree_of
from .legendre import legendre


@lru_cache(maxsize=32)
def gauss_rows(n: int) -> tuple[FloatArray, FloatArray]:
    """Heights from north to south, and weights of sum 2, exact for polynomials in z of degree 2 n - 1.

    Newton's method on the colatitude keeps near the poles the digits that it loses on z: two of them at 200 rows.
    """
    theta = np.pi * (np.arange(n) + 0.75) / (n + 0.5)  # off by O(n^-2) of their distance: Newton doubles the digits
    for _ in range(4):
        z = np.cos(theta)
        last, P = np.ones(n), z
        for ell in range(1, n):
            last, P = P, ((2 * ell + 1) * z * P - ell * last) / (ell + 1)
        slope = n * (z * P - last) / np.sin(theta)  # dP_n / dtheta
        theta = theta - P / slope
    z, w = np.cos(theta), 2 / slope**2
    z.flags.writeable = w.flags.writeable = False  # they are kept
    return z, w


def grid_points(z: FloatArray, phi: FloatArray) -> FloatArray:
    """(rows, columns, 3) points of the sphere at heights z and longitudes phi."""
    s = np.sqrt((1 - z) * (1 + z))[:, None]
    return np.stack(np.broadcast_arrays(s * np.cos(phi), s * np.sin(phi), z[:, None]), axis=-1)


def longitudes(n: int) -> FloatArray:
    """Equal steps from 0."""
    return 2 * np.pi * np.arange(n) / n


def analysis(values: FloatArray, z: FloatArray, w: FloatArray, degree: int) -> FloatArray:
    """Coefficients ((L + 1)^2, k) of values (rows, columns, k); exact where the function's degree is L, as w and z are.

    Columns must be more than twice the degree.
    """
    n, k = values.shape[1:]
    F = np.fft.rfft(values, axis=1)[:, : degree + 1].transpose(1, 0, 2) * (2 * np.pi / n * w[:, None])  # m, z, k
    F[1:] *= np.sqrt(2)
    waves = np.concatenate((F.real, -F.imag), axis=2)
    c = np.empty(((degree + 1) ** 2, k))
    for ell, P in enumerate(legendre(degree, z, np.sqrt((1 - z) * (1 + z)))):
        each = np.matmul(P[:, None], waves[: ell + 1])[:, 0]  # m, 2 k
        middle = ell * ell + ell
        c[middle : middle + ell + 1] = each[:, :k]
        c[middle - ell : middle] = each[:0:-1, k:]
    return c


def expand(locator: SphereLocator, values: FloatArray, degree: int, oversampling: float) -> FloatArray:
    """Coefficients ((L + 1)^2, k) of the piecewise linear function with these values (n, k) at the vertices.

    Vertex sums and least squares lose by orders where vertices crowd: see docs/shapes.md.
    """
    n = math.ceil(oversampling * degree) + 2
    z, w = gauss_rows(n)
    points = grid_points(z, longitudes(2 * n)).reshape(-1, 3)
    return analysis(transfer(values, locator, points).reshape(n, 2 * n, -1), z, w, degree)


def grid_synthesis(c: FloatArray, z: FloatArray, columns: int) -> FloatArray:
    """Values (rows, columns, k); columns must be more than twice the degree."""
    degree, k = degree_of(c), c.shape[1]
    waves = np.zeros((degree + 1, len(z), 2 * k))
    for ell, P in enumerate(legendre(degree, z, np.sqrt((1 - z) * (1 + z)))):
        middle = ell * ell + ell
        each = np.zeros((ell + 1, 2 * k))
        each[:, :k] = c[middle : middle + ell + 1]
        each[1:, k:] = c[middle - ell : middle][::-1]
        waves[: ell + 1] += P[:, :, None] * each[:, None]
    waves[1:] /= np.sqrt(2)
    F = np.zeros((len(z), columns // 2 + 1, k), dtype=complex)
    F[:, : degree + 1] = (waves[..., :k] - 1j * waves[..., k:]).transpose(1, 0, 2)
    return np.fft.irfft(F, columns, axis=1, norm="forward")
