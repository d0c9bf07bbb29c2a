"""Coefficients in the order and norm of other programs: our row for each of theirs, and its factor."""

from __future__ import annotations

import math
from typing import Literal, get_args

import numpy as np

from ...mesh.arrays import FloatArray, IntArray
from .basis import degree_of, rows_of

#: Bases of coefficients: this package's, or that of a program.
Basis = Literal["orthonormal", "spharm-pdm", "ktch", "aics-shparam"]


def in_basis(c: FloatArray, basis: Basis) -> FloatArray:
    """Coefficients ((L + 1)^2, k) as an array of the shape, order and norm of a program."""
    if basis not in get_args(Basis):
        raise ValueError(f"unknown basis {basis!r}: choose {', '.join(get_args(Basis))}")
    degree = degree_of(c)
    if basis == "spharm-pdm":
        order, factors = pdm_rows(degree)
        return c[order] * factors[:, None]
    if basis == "aics-shparam":
        found = np.zeros((c.shape[1], 2, degree + 1, degree + 1))  # 0 where m > l
        for ell in range(degree + 1):
            # The mean square of a basis function is 1, and longitudes are counted from -x.
            scale = (-1.0) ** np.arange(ell + 1) / math.sqrt(4 * math.pi)
            rows = c[rows_of(ell)].T
            found[:, 0, ell, : ell + 1] = rows[:, ell:] * scale
            found[:, 1, ell, 1 : ell + 1] = rows[:, :ell][:, ::-1] * scale[1:]
        return found
    if basis == "ktch":
        return c.T.ravel()
    return c


def pdm_rows(degree: int) -> tuple[IntArray, FloatArray]:
    """Return our row for each row of SPHARM-PDM, and its factor.

    There m = 0, then cosine and sine of m = 1, 2, ...; its basis has the phase (-1)^m and no sqrt(2).
    """
    rows = [(ell, m) for ell in range(degree + 1) for m in range(-ell, ell + 1)]
    ell, m = np.array(sorted(rows, key=lambda row: (row[0], abs(row[1]), -row[1]))).T
    return ell * ell + ell + m, np.where(m == 0, 1.0, (-1.0) ** m * math.sqrt(2))
