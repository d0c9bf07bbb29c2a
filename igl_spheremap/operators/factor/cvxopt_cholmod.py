"""CHOLMOD through cvxopt: the same as through scikit-sparse, with wheels for every system, under the GPL."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import scipy.sparse as sp
from cvxopt import cholmod, matrix, sparse, spmatrix

from ...errors import FactorisationFailed
from .base import Factor, reordered
from .ordering import bandwidth_order


def build(P: sp.csc_matrix) -> Factor:
    """Factorise `P`; raise FactorisationFailed where it is not positive definite."""
    return _factorised(P, bandwidth_order(P.T))


def _factorised(P: sp.csc_matrix, order: np.ndarray, symbolic: Any = None) -> Factor:
    A = _lower_triangle(P, order)
    cholmod.options["supernodal"] = 2
    try:
        symbolic = symbolic or cholmod.symbolic(A)
        cholmod.numeric(A, symbolic)
    except ArithmeticError as error:
        raise FactorisationFailed(f"CHOLMOD: not positive definite ({error})") from error

    def solve(b: np.ndarray) -> np.ndarray:
        # Sparse right-hand sides go through the factor four at a time, dense ones one by one: a third of the time.
        x = cholmod.spsolve(symbolic, sparse(matrix(np.asfortranarray(b.reshape(len(b), -1)))))
        return np.asarray(matrix(x)).reshape(b.shape)

    again = partial(_factorised, order=order, symbolic=symbolic)
    return Factor("cvxopt", P.T, reordered(order, solve), again=again)


def _lower_triangle(P: sp.csc_matrix, order: np.ndarray) -> spmatrix:
    """Lower triangle of the symmetric matrix P[order, order], without forming the rest."""
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order), dtype=order.dtype)
    A = P.T[order]  # of a symmetric matrix the columns, in which cvxopt sorts
    rows, columns = rank.take(A.indices), np.repeat(np.arange(len(order), dtype=order.dtype), np.diff(A.indptr))
    lower = np.flatnonzero(rows >= columns)
    i, j = (matrix(index.take(lower).astype(np.int64)) for index in (rows, columns))
    return spmatrix(matrix(A.data.take(lower)), i, j, P.shape)
