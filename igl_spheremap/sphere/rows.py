"""Sums over vertices without BLAS, whose threads cost more than they save here and change the last digits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def dot(a: FloatArray, b: FloatArray) -> float:
    """Sum of the products of all entries.

    Parameters
    ----------
    a, b : (n, 3) float64 array

    Returns
    -------
    float
    """
    return float(np.einsum("ij,ij->", a, b))


def row_dots(a: FloatArray, b: FloatArray) -> FloatArray:
    """Inner product of each row of `a` with that of `b`.

    Parameters
    ----------
    a, b : (n, 3) float64 array

    Returns
    -------
    (n,) float64 array
    """
    return np.einsum("ij,ij->i", a, b)


def weighted_sum(weights: FloatArray, x: FloatArray) -> FloatArray:
    """Weighted sum of the rows.

    Parameters
    ----------
    weights : (n,) float64 array
    x : (n, 3) float64 array

    Returns
    -------
    (3,) float64 array
    """
    return np.einsum("i,ij->j", weights, x)


def weighted_moment(weights: FloatArray, x: FloatArray, y: FloatArray) -> FloatArray:
    """Weighted sum of the outer products of rows, x^T diag(weights) y.

    Parameters
    ----------
    weights : (n,) float64 array
    x, y : (n, 3) float64 array

    Returns
    -------
    (3, 3) float64 array

    Examples
    --------
    >>> weighted_moment(np.array([2.0]), np.eye(3)[:1], np.eye(3)[1:2]).tolist()
    [[0.0, 2.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    """
    columns = np.ascontiguousarray(x.T), np.ascontiguousarray(y.T)  # long inner loops
    return np.einsum("i,ji,ki->jk", weights, *columns)


def along(x: FloatArray, direction: FloatArray) -> FloatArray:
    """Component of each row along a direction.

    Parameters
    ----------
    x : (n, 3) float64 array
    direction : (3,) float64 array

    Returns
    -------
    (n,) float64 array
    """
    return np.einsum("ij,j->i", x, direction)


def normalize(x: FloatArray) -> FloatArray:
    """Divide each row by its length.

    Parameters
    ----------
    x : (n, 3) float64 array
        Nonzero rows.

    Returns
    -------
    (n, 3) float64 array
        Unit rows.

    Examples
    --------
    >>> import numpy as np
    >>> normalize(np.array([[0.0, 3.0, 4.0]]))
    array([[0. , 0.6, 0.8]])
    """
    return x / np.sqrt(row_dots(x, x))[:, None]


def tangent(x: FloatArray, h: FloatArray) -> FloatArray:
    """Part of `h` that is tangent to the sphere at `x`: A F = H - (F* H) F, eq. (9).

    Parameters
    ----------
    x : (n, 3) float64 array
        Unit rows.
    h : (n, 3) float64 array
        One vector per row of `x`.

    Returns
    -------
    (n, 3) float64 array
        Rows orthogonal to those of `x`.

    Examples
    --------
    >>> import numpy as np
    >>> tangent(np.array([[0.0, 0.0, 1.0]]), np.array([[1.0, 2.0, 3.0]]))
    array([[1., 2., 0.]])
    """
    return h - row_dots(x, h)[:, None] * x  # eq. (9)

