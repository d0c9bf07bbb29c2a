"""Vectors row by row: products, sums over vertices, unit length, stereographic projection.

No BLAS: its threads cost more than they save here, and change the last digits.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..mesh.arrays import EPS, TINY, ComplexArray, FloatArray

#: Distance in the plane that stands for infinity; its square does not overflow.
INFINITE = 1e100
#: The squared length of a unit row may differ from 1 by this after its division and a rotation.
_ROUNDING = 8 * EPS
#: In a sum of squares of this size or more, squares that underflow are less than its rounding.
_SMALLEST_SQUARE = TINY / EPS


def inner(a: FloatArray, b: FloatArray) -> float:
    """Sum of the products of all entries."""
    return float(np.einsum("ij,ij->", a, b))


def row_dots(a: FloatArray, b: FloatArray) -> FloatArray:
    """Inner product of each row of `a` with that of `b`."""
    # np.einsum takes twice as long
    if a.shape[1] == 3 and a.flags.c_contiguous and b.flags.c_contiguous:
        with np.errstate(over="ignore", invalid="ignore"):
            return column_dots(a.T, b.T)
    return np.einsum("ij,ij->i", a, b)


def column_dots(a: FloatArray, b: FloatArray) -> FloatArray:
    """Inner products of vectors whose three coordinates run along the first axis."""
    x, y, z = a * b
    return np.asarray(x + z + y)  # in the order in which np.einsum adds them


def row_crosses(a: FloatArray, b: FloatArray) -> FloatArray:
    """Cross product of each row of `a` with that of `b`; np.cross takes several times as long."""
    return column_crosses(a.T, b.T, np.empty(np.broadcast(a, b).shape, np.result_type(a, b)).T).T


def column_crosses(a: FloatArray, b: FloatArray, c: FloatArray | None = None) -> FloatArray:
    """Cross products of vectors whose coordinates run along the first axis; `c` takes them."""
    if c is None:
        c = np.empty(np.broadcast(a, b).shape, np.result_type(a, b))
    for k, part in enumerate(c):
        np.multiply(a[k - 2], b[k - 1], out=part)
        part -= a[k - 1] * b[k - 2]
    return c


def plane_crosses(a: FloatArray, b: FloatArray) -> FloatArray:
    """The cross product of rows of the plane.

    >>> float(plane_crosses(np.array([2.0, 0]), np.array([5.0, 3])))
    6.0
    """
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def row_dets(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Determinant a . (b x c) of each three rows."""
    return row_dots(a, row_crosses(b, c))


def weighted_sum(weights: FloatArray, x: FloatArray) -> FloatArray:
    """Weighted sum of the rows, or of numbers."""
    return np.asarray(np.einsum("i,i...->...", weights, x))


def weighted_moment(weights: FloatArray, x: FloatArray, y: FloatArray) -> FloatArray:
    """Weighted sum of the outer products of rows, x^T diag(weights) y.

    >>> weighted_moment(np.array([2.0]), np.eye(3)[:1], np.eye(3)[1:2]).tolist()
    [[0.0, 2.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    """
    columns = np.ascontiguousarray(x.T), np.ascontiguousarray(y.T)  # long inner loops
    return np.einsum("ji,ki->jk", weights * columns[0], columns[1])


def along(x: FloatArray, direction: FloatArray) -> FloatArray:
    """Component of each row along one direction."""
    return np.einsum("ij,j->i", x, direction)


def scale_rows(x: FloatArray) -> FloatArray:
    """Rows times powers of two that bring their largest entries to between 1/2 and 1.

    Exact, but entries 2^1000 times smaller than the largest one of their row may underflow.
    """
    return np.ldexp(x, -_exponents(x)[:, None])


def row_lengths(x: FloatArray) -> FloatArray:
    """Length of each row, of any size.

    >>> (row_lengths(np.array([[3e-200, 0, 4e-200], [3e200, 0, 4e200]])) * [1e200, 1e-200]).round(9).tolist()
    [5.0, 5.0]
    """
    square = row_dots(x, x)
    if _safe(square):
        return np.sqrt(square)
    y = scale_rows(x)
    return np.ldexp(np.sqrt(row_dots(y, y)), _exponents(x))


def unit_rows(x: FloatArray) -> FloatArray:
    """Rows divided by their lengths, of any size. Zero rows and unit rows are returned bit for bit.

    >>> unit_rows(np.array([[0.0, 3.0, 4.0], [0.0, 3e-200, 4e-200]])).tolist()
    [[0.0, 0.6, 0.8], [0.0, 0.6, 0.8]]
    """
    square, y = row_dots(x, x), x
    unit = np.abs(square - 1) < _ROUNDING
    if not _safe(square):
        y = np.where(unit[:, None], x, scale_rows(x))
        square = row_dots(y, y)
        square[square == 0] = 1
    square[unit] = 1
    return np.asarray((y.T / np.sqrt(square)).T)


def binary_sizes(x: FloatArray) -> FloatArray:
    """The power of two next above the largest entry of each row; 1 for zero rows. Division by it is exact.

    >>> binary_sizes(np.array([[3e-200, 0, 4e-200], [0.0, 0.0, 0.0]])) / [2**-662, 1]
    array([1., 1.])
    """
    return np.ldexp(1.0, _exponents(x))


def _exponents(x: FloatArray) -> NDArray[np.int32]:
    a, b, c = np.abs(x).T  # a maximum along rows of three takes ten times as long
    return np.frexp(np.maximum(np.maximum(a, b), c))[1]


def _safe(square: FloatArray) -> bool:
    """Whether sums of squares have lost no digits to under- or overflow."""
    return bool(((square > _SMALLEST_SQUARE) & (square < 1 / _SMALLEST_SQUARE)).all())


def tangent(x: FloatArray, h: FloatArray) -> FloatArray:
    """Part of `h` that is tangent to the sphere at `x`: A F = H - (F* H) F, eq. (9).

    >>> tangent(np.array([[0.0, 0.0, 1.0]]), np.array([[1.0, 2.0, 3.0]]))
    array([[1., 2., 0.]])
    """
    normal = row_dots(x, h)[:, None] * x
    return np.subtract(h, normal, out=normal)  # eq. (9)


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
    # squared cosine of half the angle from the pole; far from it the squared sine
    rest = 1 - row_dots(d, d) / 4
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
    e1, e2 = column_axes(x.T)
    return np.ascontiguousarray(e1.T), np.ascontiguousarray(e2.T)


def column_axes(columns: FloatArray) -> FloatArray:
    """Two unit vectors (2, 3, n) across each of the unit vectors (3, n), see `tangent_axes`."""
    x, y, z = columns
    s = np.where(z < 0, -1.0, 1.0)  # Duff et al. 2017, Building an Orthonormal Basis, Revisited
    p = -1 / (s + z)
    q = x * y * p
    axes = np.empty((2, *columns.shape))
    axes[0, 0], axes[0, 1], axes[0, 2] = 1 + s * x**2 * p, s * q, -s * x
    axes[1, 0], axes[1, 1], axes[1, 2] = q, s + y**2 * p, -y
    return axes
