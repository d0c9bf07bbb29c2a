"""Preconditioned conjugate gradients for several right-hand sides at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .row_blocks import Rows, times

#: Steps of conjugate gradients at the most: meshes took up to 85.
_MAX_STEPS = 200


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
            Ad[:, rows] = times(block, d)
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
