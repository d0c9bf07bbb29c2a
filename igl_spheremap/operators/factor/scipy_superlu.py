"""SuperLU as it comes with scipy, in symmetric mode without pivoting: as good as a Cholesky factorisation."""

from __future__ import annotations

from functools import partial

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from ...errors import FactorisationFailed
from .base import Factor, Solver, reordered
from .ordering import bandwidth_order, nested_dissection, renumbered

#: Below, minimum degree fills less and costs less than a dissection; far above, it takes longer than the factorisation.
_DISSECT_FROM = 40_000
#: Relative residual from which on the factorisation counts as failed.
_LARGEST_BACKWARD_ERROR = 1e-8


def build(P: sp.csr_matrix, many: bool = False) -> Factor:
    """Factorise `P`; raise FactorisationFailed where its factors aren't those of a positive definite matrix.

    Minimum degree in a mesh's own order can make twenty times the fill (spikes): it breaks ties by index.
    """
    if P.shape[0] < _DISSECT_FROM:
        order, rule = bandwidth_order(P), "MMD_AT_PLUS_A"
    else:
        order, rule = nested_dissection(P).order, "NATURAL"
    return _factorised(P, order, rule)


def _factorised(P: sp.csr_matrix, order: np.ndarray, rule: str) -> Factor:
    try:
        lu = splu(
            renumbered(P, order).T,
            permc_spec=rule,
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True, "Equil": False},
        )
    except RuntimeError as error:
        raise FactorisationFailed(f"SuperLU: {error}") from error
    solve = reordered(order, lu.solve)
    _probe(P, solve)
    return Factor("scipy", len(order), P.indices, solve, nnz=lu.nnz, again=partial(_factorised, order=order, rule=rule))


def _probe(P: sp.csr_matrix, solve: Solver) -> None:
    """SuperLU factorises indefinite matrices without an error: try the inverse on three right-hand sides."""
    i = np.arange(P.shape[0], dtype=np.float64)
    b = np.stack([np.ones_like(i), np.cos(i), np.cos(i * i % 1009.0)], axis=1)
    x = solve(b)
    backward_error = np.abs(P @ x - b).max() / (np.abs(P.data).max() * np.abs(x).max() + 1.0)
    if not ((b * x).sum(axis=0) > 0.0).all() or not backward_error < _LARGEST_BACKWARD_ERROR:
        raise FactorisationFailed("SuperLU: the matrix is not numerically positive definite")
