"""Smoothed aggregation multigrid: an approximate inverse in time and memory proportional to the matrix.

One V-cycle from a zero start, with the same polynomial smoother before and after the coarse correction, is
a fixed, symmetric, positive definite operator: a metric and a preconditioner, but no exact inverse.

References: Vanek, Mandel, Brezina (1996), *Algebraic Multigrid by Smoothed Aggregation for Second and
Fourth Order Elliptic Problems*; Adams, Brezina, Hu, Tuminaro (2003), *Parallel Multigrid Smoothing:
Polynomial versus Gauss-Seidel*.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy.sparse as sp

from ...errors import FactorisationFailed
from .conjugate_gradients import Rows, by_rows, conjugate_gradients, times
from .factor import Factor, Solver, SuperLU, factorise_by, reordered, rough_vector
from .graph_sphere import aggregate
from .ordering import bandwidth_order, renumbered

#: Levels of up to this size are factorised by SuperLU: small enough to cost nothing, and any size from 1,000 to 4,000
#: gives sample:brain:n_vertices=48000 the same levels (tried by hand, as are the next three).
_COARSEST = 2_000
#: The smoother acts on the eigenvalues between these fractions of the largest, which power steps estimate from below;
#: the coarse levels act on the rest. A solve to 1e-7 of the sample of `_COARSEST` takes 12 cycles; with .1
#: and .4 as the lower end 14 and 13, with 1.02 and 1.3 as the upper one 13 and 12, with 6 and 24 power steps 19 and 13.
_SMOOTHED_FROM, _SMOOTHED_TO = 0.2, 1.1
_POWER_STEPS = 12
#: Weight of the Jacobi step S that smooths aggregates: the largest eigenvalue of S A S is least for it, 1/9 where that
#: of A is 1 (Vanek, Mandel, Brezina 1996).
_JACOBI = 4.0 / 3.0


@dataclass(frozen=True)
class _Level:
    """A matrix whose largest eigenvalue is about 1, and the way to the next coarser level."""

    A: Rows
    prolong: Rows
    restrict: Rows


def multigrid(P: sp.csr_matrix) -> Factor:
    """Set up the hierarchy of `P`; raise FactorisationFailed where it can't be positive definite."""
    order = bandwidth_order(P)
    A, scale = _scaled(renumbered(P, order))
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
    coarsest = factorise_by(SuperLU, A)
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
    return Factor("multigrid", len(order), reordered(order, apply), nnz, refined=reordered(order, refined))


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


def _prolongation(A: sp.csr_matrix, scale: np.ndarray) -> sp.csr_matrix:
    """The aggregates' indicator functions, smoothed by a step of Jacobi."""
    n = A.shape[0]
    labels, count = aggregate(A)
    indicator = sp.csr_matrix((1.0 / scale, labels, np.arange(n + 1, dtype=np.int32)), shape=(n, count))
    step = A @ indicator
    step.data *= -_JACOBI
    return (indicator + step).tocsr()


def _largest_eigenvalue(A: sp.csr_matrix, diagonal: np.ndarray) -> float:
    """Largest eigenvalue of D^-1 A, by power steps from a fixed rough vector.

    A smoother needs no more than that, and Lanczos iteration, as Gu and Yau's descent has it, would take longer.
    """
    x = rough_vector(len(diagonal))
    for _ in range(_POWER_STEPS):
        x = A @ (x / np.sqrt(np.einsum("i,i->", x, x))) / diagonal  # no BLAS, see `rows.py`
    return float(np.sqrt(np.einsum("i,i->", x, x)))


def _smoothed(A: Rows, b: np.ndarray) -> Iterator[tuple[slice, np.ndarray]]:
    """Two steps of Chebyshev iteration from zero for A x = b, on the upper part of the spectrum, block by block."""
    # The error is T(c - lambda) / T(c) with c the middle of the part, r half its length and T(t) = 2 (t / r)^2 - 1.
    middle, radius = (_SMOOTHED_TO + _SMOOTHED_FROM) / 2.0, (_SMOOTHED_TO - _SMOOTHED_FROM) / 2.0
    for rows, block in A:
        x = 2.0 * middle * b[:, rows]
        x -= times(block, b)
        x *= 2.0 / (2.0 * middle**2 - radius**2)
        yield rows, x


def _residual(A: Rows, b: np.ndarray, x: np.ndarray, r: np.ndarray) -> None:
    """Set r to b - A x."""
    for rows, block in A:
        np.subtract(b[:, rows], times(block, x), out=r[:, rows])


def _cycle(levels: list[_Level], coarsest: Solver, b: np.ndarray, r: np.ndarray) -> np.ndarray:
    """One V-cycle from zero for right-hand sides in rows; residuals take the memory of `r`."""
    if not levels:
        return coarsest(b.T).T
    level, x = levels[0], np.empty_like(b)
    for rows, smooth in _smoothed(level.A, b):
        x[:, rows] = smooth
    _residual(level.A, b, x, r)
    coarse = np.concatenate([times(block, r) for _, block in level.restrict], axis=1)
    coarse = _cycle(levels[1:], coarsest, coarse, np.empty_like(coarse))
    for rows, block in level.prolong:
        x[:, rows] += times(block, coarse)
    _residual(level.A, b, x, r)
    for rows, smooth in _smoothed(level.A, r):
        x[:, rows] += smooth
    return x
