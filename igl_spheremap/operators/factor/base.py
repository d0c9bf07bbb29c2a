"""What every factorisation looks like from outside."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Solver = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Factor:
    """A fixed symmetric positive definite linear operator ``b -> P^-1 b``, exact or approximate.

    Attributes
    ----------
    backend : str
        Name of what made it.
    n : int
        Number of unknowns.
    apply : callable
        Maps a contiguous float64 (n,) or (n, k) array to an array of its shape.
    exact : bool
        True for a factorisation; False for a preconditioner, such as a multigrid cycle.
    nnz : int or None
        Entries stored, where that is known without cost.
    """

    backend: str
    n: int
    apply: Solver
    exact: bool = True
    nnz: int | None = None

    def solve(self, b: np.ndarray) -> np.ndarray:
        """Apply the inverse.

        Parameters
        ----------
        b : (n,) or (n, k) float64 ndarray
            Right-hand sides, one a column.

        Returns
        -------
        (n,) or (n, k) float64 ndarray
            ``P^-1 b``.

        Raises
        ------
        ValueError
            If `b` has not `n` rows.
        """
        b = np.asarray(b, dtype=np.float64)
        if b.ndim not in (1, 2) or b.shape[0] != self.n:
            raise ValueError(f"right-hand side has shape {b.shape}; expected ({self.n},) or ({self.n}, k)")
        return self.apply(b)


def reordered(order: np.ndarray, solve: Solver) -> Solver:
    """Undo a permutation around a solver.

    Parameters
    ----------
    order : (n,) ndarray of int
        Row that the solver takes as its i-th.
    solve : callable
        Solver of the permuted system.

    Returns
    -------
    callable
        Solver of the system in its own order.
    """

    def apply(b: np.ndarray) -> np.ndarray:
        x = np.empty_like(b)
        x[order] = solve(b[order])
        return x

    return apply
