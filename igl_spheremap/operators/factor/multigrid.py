"""Smoothed aggregation multigrid: an approximate inverse in time and memory proportional to the matrix.

One V-cycle from a zero start, with the same polynomial smoother before and after the coarse correction, is
a fixed, symmetric, positive definite operator: a metric and a preconditioner, but no exact inverse.

References: Vanek, Mandel, Brezina (1996), *Algebraic Multigrid by Smoothed Aggregation for Second and
Fourth Order Elliptic Problems*; Adams, Brezina, Hu, Tuminaro (2003), *Parallel Multigrid Smoothing:
Polynomial versus Gauss-Seidel*.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ...errors import FactorisationFailed
from . import scipy_superlu
from .aggregation import aggregate
from .base import Factor, Solver, reordered
from .ordering import bandwidth_order

_COARSEST = 2_000
_DEGREE = 2
# The smoother acts on the eigenvalues between these fractions of the largest; the coarse levels on the rest.
_SMOOTHED_FROM, _SMOOTHED_TO = 0.2, 1.1
_POWER_STEPS = 12


@dataclass(frozen=True)
class _Level:
    """A matrix, its scaled diagonal inverse, and the way to the next coarser level."""

    A: sp.csr_matrix
    scaling: np.ndarray  # (n, 1): 1 / (largest eigenvalue of D^-1 A times D)
    prolong: sp.csr_matrix
    restrict: sp.csr_matrix


def build(P: sp.csc_matrix) -> Factor:
    """Set up the hierarchy of `P`; raise FactorisationFailed where it can't be positive definite."""
    order = bandwidth_order(P.T)
    A = P.T[order][:, order].tocsr()
    levels = []
    while A.shape[0] > _COARSEST:
        levels.append(_coarsen(A))
        A = (levels[-1].restrict @ A @ levels[-1].prolong).tocsr()
    coarsest = scipy_superlu.build(A.tocsc())
    nnz = sum(level.A.nnz + 2 * level.prolong.nnz for level in levels) + (coarsest.nnz or 0)

    def cycle(b: np.ndarray) -> np.ndarray:
        return _cycle(levels, coarsest.apply, b.reshape(len(b), -1)).reshape(b.shape)

    return Factor("multigrid", P.T, reordered(order, cycle), exact=False, nnz=nnz)


def _coarsen(A: sp.csr_matrix) -> _Level:
    """Aggregate, and smooth the aggregates' indicator functions by a step of Jacobi."""
    n = A.shape[0]
    diagonal = A.diagonal()
    if not diagonal.min() > 0.0:
        raise FactorisationFailed("multigrid: the diagonal is not positive")
    scaling = 1.0 / (_largest_eigenvalue(A, diagonal) * diagonal)
    labels, count = aggregate(A)
    indicator = sp.csr_matrix((np.ones(n), labels, np.arange(n + 1, dtype=np.int32)), shape=(n, count))
    step = A @ indicator
    step.data *= np.repeat(-4.0 / 3.0 * scaling, np.diff(step.indptr))
    prolong = (indicator + step).tocsr()
    return _Level(A, scaling[:, None], prolong, prolong.T.tocsr())


def _largest_eigenvalue(A: sp.csr_matrix, diagonal: np.ndarray) -> float:
    """Largest eigenvalue of D^-1 A, by power steps from a fixed rough vector.

    A smoother needs no more than that, and Lanczos iteration, as Gu and Yau's descent has it, would take longer.
    """
    x = np.cos(np.arange(len(diagonal), dtype=np.float64) ** 2 % 1009.0)
    for _ in range(_POWER_STEPS):
        x = A @ (x / np.linalg.norm(x)) / diagonal
    return float(np.linalg.norm(x))


def _smooth(level: _Level, b: np.ndarray, x: np.ndarray | None) -> np.ndarray:
    """Chebyshev iteration for A x = b on the upper part of the spectrum; from zero if `x` is None."""
    centre, radius = (_SMOOTHED_TO + _SMOOTHED_FROM) / 2.0, (_SMOOTHED_TO - _SMOOTHED_FROM) / 2.0
    residual = b if x is None else b - level.A @ x
    step = level.scaling * residual
    step /= centre
    x = step.copy() if x is None else x + step
    rho = radius / centre
    for _ in range(_DEGREE - 1):
        residual = residual - level.A @ step
        following = 1.0 / (2.0 * centre / radius - rho)
        step *= following * rho
        step += (2.0 * following / radius) * (level.scaling * residual)
        x += step
        rho = following
    return x


def _cycle(levels: list[_Level], coarsest: Solver, b: np.ndarray) -> np.ndarray:
    """One V-cycle from zero."""
    if not levels:
        return coarsest(b)
    level = levels[0]
    x = _smooth(level, b, None)
    x += level.prolong @ _cycle(levels[1:], coarsest, level.restrict @ (b - level.A @ x))
    return _smooth(level, b, x)
