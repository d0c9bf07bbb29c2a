"""Stereographic projection at any depth: positions in the plane as complex logarithms, points in long doubles.

A complex logarithm is a log distance and a direction. With deep limbs, distances in the plane range over thousands of
nepers (factors of e), and float64 ends at 709.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..mesh.arrays import ComplexArray, FloatArray, IntArray
from .rows import INFINITE

LongComplex = NDArray[np.clongdouble]
LongFloat = NDArray[np.longdouble]


def logarithm(z: ComplexArray | complex) -> ComplexArray:
    """Complex logarithms; that of 0 has the real part -inf."""
    with np.errstate(divide="ignore"):
        return np.log(np.asarray(z, dtype=np.complex128))


def exponential(log: ComplexArray) -> ComplexArray:
    """Numbers of given logarithms, none larger than `INFINITE`."""
    return np.asarray(np.exp(np.minimum(log.real, np.log(INFINITE)) + 1j * log.imag))


def log_sum(a: ComplexArray, b: ComplexArray | complex) -> ComplexArray:
    """Logarithms of sums, given those of the terms.

    >>> complex(np.exp(log_sum(np.log(np.array([3j])), np.log(4 + 0j)))[0].round(9))
    (4+3j)
    """
    unit = np.maximum(np.maximum(a.real, np.asarray(b).real), np.finfo(float).min)
    return unit + logarithm(np.exp(a - unit) + np.exp(b - unit))


class Anchored(NamedTuple):
    """Points of the plane, each relative to an anchor, 0 or a number of length 1: close to it no digits are lost."""

    z: ComplexArray | LongComplex
    anchor: ComplexArray | complex = 0j

    def turned(self) -> ComplexArray | LongComplex:
        """Points after the rotations of the sphere that take their anchors to 0."""
        return np.asarray(self.z / (1 + np.abs(self.anchor) ** 2 + np.conj(self.anchor) * self.z))

    def beside(
        self, k: int, offset: ComplexArray | LongComplex, rows: IntArray
    ) -> ComplexArray | LongComplex:
        """Points at given offsets from point k, relative to the anchors of the given rows."""
        anchor = np.broadcast_to(self.anchor, self.z.shape)
        return np.asarray(self.z[k] + (anchor[k] - anchor[rows]) + offset)


def to_ball(points: Anchored) -> LongFloat:
    """Inverse stereographic projection in long doubles, 0 to (0, 0, 1), infinity to (0, 0, -1), without overflow.

    Close to an anchor two of the coordinates keep all digits of the position.

    >>> to_ball(Anchored(np.array([1e-300 + 0j]), np.array([1j]))).astype(float).tolist()
    [[1e-300, 1.0, -0.0]]
    """
    anchor, z = points.anchor, Anchored(points.z.astype(np.clongdouble), points.anchor).turned()
    far = np.abs(z) > 1
    u = np.where(far, 1 / np.where(far, z, 1).conj(), z)
    q = u.real**2 + u.imag**2
    x, height = 2 * u / (1 + q), np.where(far, q - 1, 1 - q) / (1 + q)
    along = x * np.conj(anchor)  # its imaginary part is the coordinate across
    plane = np.where(anchor == 0, x, anchor * (height + 1j * along.imag))
    return np.column_stack((plane.real, plane.imag, np.where(anchor == 0, height, -along.real)))


def rows_at(log: ComplexArray) -> FloatArray:
    """Unit rows, in float64, at points of the plane by their complex logarithms."""
    return to_ball(Anchored(exponential(log))).astype(np.float64)


def plane_angles(z: ComplexArray) -> FloatArray:
    """Signed corner angles of triangles in the plane, (m, 3): negative where folded, 0 where corners coincide."""
    after, before = np.roll(z, -1, axis=1) - z, np.roll(z, 1, axis=1) - z
    return np.angle(before * after.conj())
