"""CHOLMOD through cvxopt: the same as through scikit-sparse, with wheels for every system, under the GPL."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from cvxopt import cholmod, matrix, spmatrix

from ..errors import FactorisationFailed
from ..ordering import bandwidth_order
from .base import Factor, reordered


def build(P: sp.csc_matrix) -> Factor:
    """Factorise `P`; raise FactorisationFailed where it is not positive definite."""
    order = bandwidth_order(P.T)
    lower = sp.tril(P[order][:, order]).tocoo()
    rows, columns = lower.row.astype(np.int64), lower.col.astype(np.int64)
    A = spmatrix(matrix(lower.data), matrix(rows), matrix(columns), P.shape)
    cholmod.options["supernodal"] = 2
    try:
        symbolic = cholmod.symbolic(A)
        cholmod.numeric(A, symbolic)
    except ArithmeticError as error:
        raise FactorisationFailed(f"CHOLMOD: not positive definite ({error})") from error

    def solve(b: np.ndarray) -> np.ndarray:
        x = matrix(np.asfortranarray(b.reshape(len(b), -1)))
        cholmod.solve(symbolic, x)
        return np.asarray(x).reshape(b.shape)

    return Factor("cvxopt", P.shape[0], reordered(order, solve))
