"""Coefficients in the order and norm of other programs: which of our rows each of theirs is, and its factor."""

from __future__ import annotations

import math
from typing import Literal, get_args

import numpy as np

from ...mesh.arrays import FloatArray, IntArray
from .basis import degree_of

#: Whose basis coefficients are in: this package's, or that of a program.
Basis = Literal["orthonormal", "spharm-pdm", "ktch", "aics-shparam"]


def in_basis(c: FloatArray, basis: Basis) -> FloatArray:
    """Coefficients ((L + 1)^2, k) as an array of the shape, order and norm of a program."""
    if basis not in get_args(Basis):
        raise ValueError(f"unknown basis {basis!r}: choose {', '.join(get_args(Basis))}")
    degree = degree_of(c)
    if basis == "spharm-pdm":
        order, factors = pdm_rows(degree)
        return np.asarray(c[order] * factors[:, None])
    if basis == "aics-shparam":
        return aics_values(c).reshape(-1, 2, degree + 1, degree + 1)
    return c.T.ravel() if basis == "ktch" else c


def pdm_rows(degree: int) -> tuple[IntArray, FloatArray]:
    """Return which of our rows each row of SPHARM-PDM is, and its factor.

    There m = 0, then cosine and sine of m = 1, 2, ...; its basis has the phase (-1)^m and no sqrt(2).
    """
    ell, m = np.array([(ell, m) for ell in range(degree + 1)
                       for m in sorted(range(-ell, ell + 1), key=lambda m: (abs(m), -m))]).T
    return ell * ell + ell + m, np.where(m == 0, 1.0, (-1.0) ** m * math.sqrt(2))


def aics_values(c: FloatArray) -> FloatArray:
    """Coefficients (k, 2 (L + 1)^2) in aics-shparam's order, 0 where m > l."""
    _, order, factors = aics_columns(degree_of(c))
    return np.asarray(np.vstack((c, np.zeros_like(c[:1])))[order].T * factors)


def aics_columns(degree: int) -> tuple[list[str], IntArray, FloatArray]:
    """Names in aics-shparam's order, which of our rows each is (the one behind the last where m > l), and its factor.

    There the mean square of a basis function is 1, and longitudes are counted from -x.
    """
    keys = [(part, ell, m) for part in "CS" for ell in range(degree + 1) for m in range(degree + 1)]
    rows = [ell * ell + ell + (m if part == "C" else -m) if m <= ell and (part == "C" or m) else (degree + 1) ** 2
            for part, ell, m in keys]
    factors = np.array([(-1.0) ** m / math.sqrt(4 * math.pi) for _, _, m in keys])
    return [f"shcoeffs_L{ell}M{m}{part}" for part, ell, m in keys], np.array(rows), factors
