"""Solves to a stated accuracy with any factor, exact or not."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from .base import Factor

_MAX_STEPS = 200


def refined_solve(P: sp.csr_matrix, factor: Factor, b: np.ndarray, rtol: float = 1e-6) -> np.ndarray:
    """Solve ``P x = b``, by conjugate gradients where the factor is only approximate.

    Parameters
    ----------
    P : (n, n) sparse matrix
        The matrix that was factorised.
    factor : Factor
        Its factor; an exact one is applied once.
    b : (n,) or (n, k) float64 ndarray
        Right-hand sides.
    rtol : float
        Residual to reach, in the norm of P^-1 and relative to that of `b`, column by column.

    Returns
    -------
    (n,) or (n, k) float64 ndarray
        The solution; after 200 steps, as far as it came.

    Examples
    --------
    >>> from . import factorize
    >>> P = sp.diags_array([2.0, 4.0]).tocsr()
    >>> refined_solve(P, factorize(P, "scipy"), np.array([1.0, 1.0])).tolist()
    [0.5, 0.25]
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
