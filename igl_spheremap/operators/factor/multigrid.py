"""Smoothed aggregation multigrid: an approximate inverse in time and memory proportional to the matrix.

One V-cycle from a zero start, with the same polynomial smoother before and after the coarse correction, is
a fixed, symmetric, positive definite operator: a metric and a preconditioner, but no exact inverse.

References: Vanek, Mandel, Brezina (1996), *Algebraic Multigrid by Smoothed Aggregation for Second and
Fourth Order Elliptic Problems*; Adams, Brezina, Hu, Tuminaro (2003), *Parallel Multigrid Smoothing:
Polynomial versus Gauss-Seidel*.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy.sparse as sp

from ...errors import FactorisationFailed
from . import scipy_superlu
from .aggregation import aggregate
from .base import Factor, Solver, reordered
from .ordering import bandwidth_order, renumbered

#: Levels of up to this size are factorised by SuperLU.
_COARSEST = 2_000
#: The smoother acts on the eigenvalues between these fractions of the largest, which power steps estimate from below;
#: the coarse levels act on the rest.
_SMOOTHED_FROM, _SMOOTHED_TO = 0.2, 1.1
_POWER_STEPS = 12
#: Steps of conjugate gradients at the most: meshes took up to 85.
_MAX_STEPS = 200
#: Rows whose products are made at once: they fit the cache, and their memory is used again. That of millions of rows
#: would be taken from the system, page by page, for every product.
_BLOCK = 1 << 14

Rows = list[tuple[slice, sp.csr_matrix]]


@dataclass(frozen=True)
class _Level:
    """A matrix whose largest eigenvalue is about 1, and the way to the next coarser level."""

    A: Rows
    prolong: Rows
    restrict: Rows


def build(P: sp.csc_matrix) -> Factor:
    """Set up the hierarchy of `P`; raise FactorisationFailed where it can't be positive definite."""
    order = bandwidth_order(P.T)
    A, scale = _scaled(renumbered(P.T, order))
    root, levels, nnz = scale, [], 0
    finest = rows = by_rows(A)
    while A.shape[0] > _COARSEST:
        prolong = _prolongation(A, scale)
        restrict = prolong.T.tocsr()
        coarse, scale = _scaled((restrict @ A @ prolong).tocsr())
        prolong.data *= scale.take(prolong.indices)
        restrict.data *= scale.repeat(np.diff(restrict.indptr))
        levels.append(_Level(rows, by_rows(prolong), by_rows(restrict)))
        nnz += A.nnz + 2 * prolong.nnz
        A, rows = coarse, by_rows(coarse)
    coarsest = scipy_superlu.build(A.tocsc())
    cycle = partial(_cycle, levels, coarsest.apply)

    def apply(b: np.ndarray) -> np.ndarray:
        r = root * np.atleast_2d(b.T)
        return (root * cycle(r, np.empty_like(r))).T.reshape(b.shape)

    def refined(b: np.ndarray, accuracy: float) -> np.ndarray:
        r = b.T
        r *= root
        x = conjugate_gradients(finest, cycle, r, accuracy)
        x *= root
        return x.T

    nnz += coarsest.nnz or 0
    return Factor("multigrid", len(order), P.indices, reordered(order, apply), nnz, refined=reordered(order, refined))


def _scaled(A: sp.csr_matrix) -> tuple[sp.csr_matrix, np.ndarray]:
    """R A R, in the memory of A, and the diagonal R for which all diagonal entries are one over the largest eigenvalue.

    In the variables x / R neither smoother nor conjugate gradients have to be weighted.
    """
    diagonal = A.diagonal()
    if not diagonal.min() > 0.0:
        raise FactorisationFailed("multigrid: the diagonal is not positive")
    scale = 1.0 / np.sqrt(_largest_eigenvalue(A, diagonal) * diagonal)
    A.data *= scale.repeat(np.diff(A.indptr))
    A.data *= scale.take(A.indices)
    return A, scale


def by_rows(A: sp.csr_matrix) -> Rows:
    """A matrix in blocks of rows, in its own memory."""
    blocks = []
    for first in range(0, A.shape[0], _BLOCK):
        start = A.indptr[first : first + _BLOCK + 1]
        block = sp.csr_matrix((len(start) - 1, A.shape[1]))
        block.indptr = start - start[0]  # given to the constructor, views are copied
        block.data, block.indices = (values[start[0] : start[-1]] for values in (A.data, A.indices))
        blocks.append((slice(first, first + _BLOCK), block))
    return blocks


def _times(block: sp.csr_matrix, x: np.ndarray) -> np.ndarray:
    """Product with fields in rows: column by column takes two thirds of the time of all at once."""
    return np.array([block @ field for field in x])


def _prolongation(A: sp.csr_matrix, scale: np.ndarray) -> sp.csr_matrix:
    """The aggregates' indicator functions, smoothed by a step of Jacobi."""
    n = A.shape[0]
    labels, count = aggregate(A)
    indicator = sp.csr_matrix((1.0 / scale, labels, np.arange(n + 1, dtype=np.int32)), shape=(n, count))
    step = A @ indicator
    step.data *= -4.0 / 3.0
    return (indicator + step).tocsr()


def _largest_eigenvalue(A: sp.csr_matrix, diagonal: np.ndarray) -> float:
    """Largest eigenvalue of D^-1 A, by power steps from a fixed rough vector.

    A smoother needs no more than that, and Lanczos iteration, as Gu and Yau's descent has it, would take longer.
    """
    x = np.cos(np.arange(len(diagonal), dtype=np.float64) ** 2 % 1009.0)
    for _ in range(_POWER_STEPS):
        x = A @ (x / np.sqrt(np.einsum("i,i->", x, x))) / diagonal  # no BLAS, see `rows.py`
    return float(np.sqrt(np.einsum("i,i->", x, x)))


def _smoothed(A: Rows, b: np.ndarray) -> Iterator[tuple[slice, np.ndarray]]:
    """Two steps of Chebyshev iteration from zero for A x = b, on the upper part of the spectrum, block by block."""
    # The error is T(c - lambda) / T(c) with c the middle of the part, r half its length and T(t) = 2 (t / r)^2 - 1.
    middle, radius = (_SMOOTHED_TO + _SMOOTHED_FROM) / 2.0, (_SMOOTHED_TO - _SMOOTHED_FROM) / 2.0
    for rows, block in A:
        x = 2.0 * middle * b[:, rows]
        x -= _times(block, b)
        x *= 2.0 / (2.0 * middle**2 - radius**2)
        yield rows, x


def _cycle(levels: list[_Level], coarsest: Solver, b: np.ndarray, r: np.ndarray) -> np.ndarray:
    """One V-cycle from zero for right-hand sides in rows; residuals take the memory of `r`."""
    if not levels:
        return coarsest(b.T).T
    level, x = levels[0], np.empty_like(b)
    for rows, smooth in _smoothed(level.A, b):
        x[:, rows] = smooth
    for rows, block in level.A:
        np.subtract(b[:, rows], _times(block, x), out=r[:, rows])
    coarse = np.concatenate([_times(block, r) for _, block in level.restrict], axis=1)
    coarse = _cycle(levels[1:], coarsest, coarse, np.empty_like(coarse))
    for rows, block in level.prolong:
        x[:, rows] += _times(block, coarse)
    for rows, block in level.A:
        np.subtract(b[:, rows], _times(block, x), out=r[:, rows])
    for rows, smooth in _smoothed(level.A, r):
        x[:, rows] += smooth
    return x


def conjugate_gradients(
    A: Rows, precondition: Callable[..., np.ndarray], b: np.ndarray, accuracy: float
) -> np.ndarray:
    """Solve A x = b row by row of b, until each residual has fallen to `accuracy` in the preconditioner's norm.

    The residual takes the memory of `b`: there are millions of columns.
    """
    r, x, Ad = b, np.zeros_like(b), np.empty_like(b)
    d = z = precondition(r, Ad)
    rz = first = np.einsum("ij,ij->i", r, z)
    for _ in range(_MAX_STEPS):
        if (rz <= accuracy**2 * first).all():
            break
        for rows, block in A:
            Ad[:, rows] = _times(block, d)
        alpha = _ratio(rz, np.einsum("ij,ij->i", d, Ad))
        Ad *= alpha
        r -= Ad
        x += np.multiply(d, alpha, out=Ad)
        z = precondition(r, Ad)
        before, rz = rz, np.einsum("ij,ij->i", r, z)
        d *= _ratio(rz, before)
        d += z
    return x


def _ratio(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a / b as a column, and 0 where b is 0: a field that has converged exactly stays where it is."""
    return np.divide(a, b, out=np.zeros_like(a), where=b != 0.0)[:, None]
