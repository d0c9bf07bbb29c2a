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
from .ordering import bandwidth_order, renumbered

#: Levels of up to this size are factorised by SuperLU.
_COARSEST = 2_000
#: The smoother acts on the eigenvalues between these fractions of the largest, which power steps estimate from below;
#: the coarse levels act on the rest.
_SMOOTHED_FROM, _SMOOTHED_TO = 0.2, 1.1
_POWER_STEPS = 12
#: Steps of conjugate gradients at the most: meshes took up to 85.
_MAX_STEPS = 200


@dataclass(frozen=True)
class _Level:
    """A matrix whose largest eigenvalue is about 1, and the way to the next coarser level."""

    A: sp.csr_matrix
    prolong: sp.csr_matrix
    restrict: sp.csr_matrix


def build(P: sp.csc_matrix) -> Factor:
    """Set up the hierarchy of `P`; raise FactorisationFailed where it can't be positive definite."""
    order = bandwidth_order(P.T)
    finest, root = A, scale = _scaled(renumbered(P.T, order))
    levels = []
    while A.shape[0] > _COARSEST:
        prolong = _prolongation(A, scale)
        restrict = prolong.T.tocsr()
        coarse, scale = _scaled((restrict @ A @ prolong).tocsr())
        prolong.data *= scale.take(prolong.indices)
        restrict.data *= scale.repeat(np.diff(restrict.indptr))
        levels.append(_Level(A, prolong, restrict))
        A = coarse
    coarsest = scipy_superlu.build(A.tocsc())
    nnz = sum(level.A.nnz + 2 * level.prolong.nnz for level in levels) + (coarsest.nnz or 0)

    def cycle(b: np.ndarray) -> np.ndarray:
        return _cycle(levels, coarsest.apply, b)

    def apply(b: np.ndarray) -> np.ndarray:
        x = root[:, None] * cycle(np.ascontiguousarray(root[:, None] * b.reshape(len(b), -1)))
        return x.reshape(b.shape)

    def refined(b: np.ndarray, accuracy: float) -> np.ndarray:
        x = _conjugate_gradients(finest, cycle, np.ascontiguousarray(root[:, None] * b), accuracy)
        x *= root[:, None]
        return x

    return Factor("multigrid", P.T, reordered(order, apply), nnz=nnz, refined=reordered(order, refined))


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
    step.data *= -4.0 / 3.0
    return (indicator + step).tocsr()


def _largest_eigenvalue(A: sp.csr_matrix, diagonal: np.ndarray) -> float:
    """Largest eigenvalue of D^-1 A, by power steps from a fixed rough vector.

    A smoother needs no more than that, and Lanczos iteration, as Gu and Yau's descent has it, would take longer.
    """
    x = np.cos(np.arange(len(diagonal), dtype=np.float64) ** 2 % 1009.0)
    for _ in range(_POWER_STEPS):
        x = A @ (x / np.linalg.norm(x)) / diagonal
    return float(np.linalg.norm(x))


def _smooth(A: sp.csr_matrix, b: np.ndarray) -> np.ndarray:
    """Two steps of Chebyshev iteration from zero for A x = b, on the upper part of the spectrum."""
    # The error is T(c - lambda) / T(c) with c the middle of the part, r half its length and T(t) = 2 (t / r)^2 - 1.
    middle, radius = (_SMOOTHED_TO + _SMOOTHED_FROM) / 2.0, (_SMOOTHED_TO - _SMOOTHED_FROM) / 2.0
    x = 2.0 * middle * b
    x -= A @ b
    x *= 2.0 / (2.0 * middle**2 - radius**2)
    return x


def _cycle(levels: list[_Level], coarsest: Solver, b: np.ndarray) -> np.ndarray:
    """One V-cycle from zero."""
    if not levels:
        return coarsest(b)
    level = levels[0]
    x = _smooth(level.A, b)
    x += level.prolong @ _cycle(levels[1:], coarsest, level.restrict @ (b - level.A @ x))
    x += _smooth(level.A, b - level.A @ x)
    return x


def _conjugate_gradients(A: sp.csr_matrix, precondition: Solver, b: np.ndarray, accuracy: float) -> np.ndarray:
    """Solve A x = b column by column, until each residual has fallen to `accuracy` in the preconditioner's norm.

    The residual takes the memory of `b`: there are millions of rows.
    """
    r, x = b, np.zeros_like(b)
    d = z = precondition(r)
    rz = first = np.einsum("ij,ij->j", r, z)
    for _ in range(_MAX_STEPS):
        if (rz <= accuracy**2 * first).all():
            break
        Ad = A @ d
        alpha = _ratio(rz, np.einsum("ij,ij->j", d, Ad))
        Ad *= alpha
        r -= Ad
        x += np.multiply(d, alpha, out=Ad)
        del Ad
        z = precondition(r)
        before, rz = rz, np.einsum("ij,ij->j", r, z)
        d *= _ratio(rz, before)
        d += z
    return x


def _ratio(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a / b, and 0 where b is 0: a column that has converged exactly stays where it is."""
    return np.divide(a, b, out=np.zeros_like(a), where=b != 0.0)
