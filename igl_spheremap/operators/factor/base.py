"""What every solver looks like from outside."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ...mesh.timings import stage

Solver = Callable[[np.ndarray], np.ndarray]

_MAX_STEPS = 200


@dataclass(frozen=True, eq=False)
class Factor:
    """A symmetric positive definite matrix and a fixed operator that is its inverse, exactly or about."""

    backend: str
    P: sp.csr_matrix
    apply: Solver  # takes contiguous float64 (n,) or (n, k) arrays
    exact: bool = True  # False for a multigrid cycle, which is symmetric positive definite, too
    nnz: int | None = None  # entries stored, where that is known without cost
    #: Factorises a matrix of the same pattern in less time. It may take the memory of this factor, which is lost then.
    again: Callable[[sp.csc_matrix], Factor] | None = None

    @stage("solves")
    def solve(self, b: np.ndarray, accuracy: float = 1e-8) -> np.ndarray:
        """``P^-1 b`` for right-hand sides in the columns of an (n,) or (n, k) array.

        Where the operator is not exact it preconditions at most 200 steps of conjugate gradients, until the residual of
        each column has fallen to `accuracy` times that of `b`, in the norm of P^-1.
        """
        b = np.asarray(b, dtype=np.float64)
        n = self.P.shape[0]
        if b.ndim not in (1, 2) or b.shape[0] != n:
            raise ValueError(f"right-hand side has shape {b.shape}; expected ({n},) or ({n}, k)")
        return self.apply(b) if self.exact else self._refined(b.reshape(n, -1), accuracy).reshape(b.shape)

    def _refined(self, b: np.ndarray, accuracy: float) -> np.ndarray:
        """Conjugate gradients, column by column."""
        r, x = b.copy(), np.zeros_like(b)
        d = z = self.apply(r)
        rz = first = np.einsum("ij,ij->j", r, z)
        for _ in range(_MAX_STEPS):
            if (rz <= accuracy**2 * first).all():
                break
            Pd = self.P @ d
            alpha = _ratio(rz, np.einsum("ij,ij->j", d, Pd))
            x += alpha * d
            r -= alpha * Pd
            z = self.apply(r)
            before, rz = rz, np.einsum("ij,ij->j", r, z)
            d = z + _ratio(rz, before) * d
        return x


def reordered(order: np.ndarray, solve: Solver) -> Solver:
    """Solver of a system in its own order, by that of the system whose i-th row is row ``order[i]``."""
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order), dtype=order.dtype)

    def apply(b: np.ndarray) -> np.ndarray:
        x = np.empty_like(b)
        x.T[...] = solve(b.T.take(order, axis=-1).T).T.take(rank, axis=-1)
        return x

    return apply


def _ratio(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a / b, and 0 where b is 0: a column that has converged exactly stays where it is."""
    return np.divide(a, b, out=np.zeros_like(a), where=b != 0.0)
