"""The common interface of all solvers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ...mesh.timings import stage

Solver = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True, eq=False)
class Factor:
    """A fixed operator that is the inverse of a symmetric positive definite matrix, exactly or approximately."""

    backend: str
    n: int
    indices: np.ndarray  # columns of the matrix's entries, row by row: its values are not kept
    apply: Solver  # takes contiguous float64 (n,) or (n, k) arrays
    nnz: int | None = None  # entries stored, where that is known without cost
    #: Factorises a matrix of the same pattern in less time. It may take the memory of this factor, which is lost then.
    again: Callable[[sp.csr_matrix], Factor] | None = None
    #: Where `apply` is only approximate: solves (n, k) systems to an accuracy, preconditioned by it.
    refined: Callable[[np.ndarray, float], np.ndarray] | None = None

    @property
    def exact(self) -> bool:
        """False for a multigrid cycle, which is symmetric positive definite, too."""
        return self.refined is None

    @stage("solves")
    def solve(self, b: np.ndarray, accuracy: float = 1e-8) -> np.ndarray:
        """``P^-1 b`` for right-hand sides in the columns of an (n,) or (n, k) array.

        Where the operator is not exact it preconditions at most 200 steps of conjugate gradients, until the residual of
        each column has fallen to `accuracy` times that of `b`, in the norm of P^-1.
        """
        b = np.asarray(b, dtype=np.float64)
        if b.ndim not in (1, 2) or b.shape[0] != self.n:
            raise ValueError(f"right-hand side has shape {b.shape}; expected ({self.n},) or ({self.n}, k)")
        if self.refined is None:
            return self.apply(b)
        return self.refined(b.reshape(self.n, -1), accuracy).reshape(b.shape)


def inverse_permutation(order: np.ndarray) -> np.ndarray:
    """The place of each index in an order."""
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order), dtype=order.dtype)
    return rank


def reordered(order: np.ndarray, solve: Callable[..., np.ndarray]) -> Callable[..., np.ndarray]:
    """Solver of a system from one of the same system reordered, whose i-th row is row ``order[i]`` of the first."""
    rank = inverse_permutation(order)

    def apply(b: np.ndarray, *options: float) -> np.ndarray:
        x = np.empty_like(b)
        x.T[...] = solve(b.T.take(order, axis=-1).T, *options).T.take(rank, axis=-1)
        return x

    return apply
