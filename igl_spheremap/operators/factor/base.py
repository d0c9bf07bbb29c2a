"""What every solver looks like from outside, and solves to a stated accuracy with any of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

Solver = Callable[[np.ndarray], np.ndarray]

_MAX_STEPS = 200


@dataclass(frozen=True)
class Factor:
    """A fixed symmetric positive definite operator ``b -> P^-1 b``, exact or approximate."""

    backend: str
    n: int  # number of unknowns
    apply: Solver  # takes contiguous float64 (n,) or (n, k) arrays
    exact: bool = True  # False for a multigrid cycle
    nnz: int | None = None  # entries stored, where that is known without cost

    def solve(self, b: np.ndarray) -> np.ndarray:
        """``P^-1 b`` for right-hand sides in the columns of an (n,) or (n, k) array."""
        b = np.asarray(b, dtype=np.float64)
        if b.ndim not in (1, 2) or b.shape[0] != self.n:
            raise ValueError(f"right-hand side has shape {b.shape}; expected ({self.n},) or ({self.n}, k)")
        return self.apply(b)


def reordered(order: np.ndarray, solve: Solver) -> Solver:
    """Solver of a system in its own order, by that of the system whose i-th row is row ``order[i]``."""

    def apply(b: np.ndarray) -> np.ndarray:
        x = np.empty_like(b)
        x[order] = solve(b[order])
        return x

    return apply


def refined_solve(P: sp.csr_matrix, factor: Factor, b: np.ndarray, rtol: float = 1e-6) -> np.ndarray:
    """Solve ``P x = b``: at once by an exact factor, else by at most 200 steps of conjugate gradients.

    `rtol` is the residual to reach in each column, in the norm of P^-1 and relative to that of `b`.
    """
    if factor.exact:
        return factor.solve(b)
    r = np.array(b, dtype=np.float64).reshape(len(b), -1)
    x = np.zeros_like(r)
    z = factor.solve(r)
    d = z
    rz = first = np.einsum("ij,ij->j", r, z)
    for _ in range(_MAX_STEPS):
        if (rz <= rtol**2 * first).all():
            break
        Pd = P @ d
        alpha = _ratio(rz, np.einsum("ij,ij->j", d, Pd))
        x += alpha * d
        r -= alpha * Pd
        z = factor.solve(r)
        before, rz = rz, np.einsum("ij,ij->j", r, z)
        d = z + _ratio(rz, before) * d
    return x.reshape(np.shape(b))


def _ratio(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a / b, and 0 where b is 0: a column that has converged exactly stays where it is."""
    return np.divide(a, b, out=np.zeros_like(a), where=b != 0.0)
