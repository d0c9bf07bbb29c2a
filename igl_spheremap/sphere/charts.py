"""Stereographic projection, both ways, and axes of tangent planes."""

from __future__ import annotations

import numpy as np

from ..mesh.arrays import ComplexArray, FloatArray
from .rows import row_dots

#: Distance in the plane that is as good as infinite, and whose square is finite.
INFINITE = 1e100


def to_chart(x: FloatArray, pole: FloatArray) -> ComplexArray:
    """Project unit rows from the point opposite to a pole to the plane that touches the sphere at the pole.

    Distances from either point keep their relative precision. `pole` is one (1, 3) row, or one for each of `x`.

    >>> to_chart(np.array([[0, 0, 1.0], [1, 0, 0], [0, 0.8, -0.6]]), np.array([[0, 0, 1.0]])).imag.round(12)
    array([0., 0., 4.])
    """
    far = row_dots(x, np.broadcast_to(pole, x.shape)) < 0
    d = np.where(far[:, None], x + pole, x - pole)
    e1, e2 = (np.broadcast_to(axis, x.shape) for axis in tangent_axes(pole))
    across = row_dots(d, e1) + 1j * row_dots(d, e2)
    across[far & (across == 0)] = 4 / INFINITE
    rest = 1 - row_dots(d, d) / 4  # squared cosine of half the angle from the pole; where far, its squared sine
    return np.asarray(np.where(far, 4 * rest, across) / np.where(far, across.conj(), rest))


def from_chart(z: ComplexArray, pole: FloatArray) -> FloatArray:
    """Inverse of `to_chart`."""
    e1, e2 = tangent_axes(pole)
    w = (z.real**2 + z.imag**2) / 4
    x = pole.T * (1 - w)
    x += e1.T * z.real
    x += e2.T * z.imag
    x /= 1 + w
    return x.T


def tangent_axes(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors across each unit row, chosen so that tiny components keep their relative precision."""
    s = np.where(x[:, 2] < 0, -1.0, 1.0)  # Duff et al. 2017, Building an Orthonormal Basis, Revisited
    p = -1 / (s + x[:, 2])
    q = x[:, 0] * x[:, 1] * p
    e1 = np.stack((1 + s * x[:, 0] ** 2 * p, s * q, -s * x[:, 0]), axis=1)
    e2 = np.stack((q, s + x[:, 1] ** 2 * p, -x[:, 1]), axis=1)
    return e1, e2
