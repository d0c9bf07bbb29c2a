"""CHOLMOD through cvxopt: the same as through scikit-sparse, with wheels for every system, under the GPL."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import scipy.sparse as sp
from cvxopt import cholmod, matrix, sparse, spmatrix

from ...errors import FactorisationFailed
from .base import Factor, inverse_permutation, reordered
from .ordering import bandwidth_order, nested_dissection

#: From here on a dissection takes no longer than minimum degree, and on folded surfaces it fills less.
_DISSECT_FROM = 100_000


def build(P: sp.csr_matrix, many: bool = False) -> Factor:
    """Factorise `P`; raise FactorisationFailed where it is not positive definite.

    If `many` of its pattern follow, a dissection competes with minimum degree, which fills less on limbs.
    """
    dissect = P.shape[0] >= _DISSECT_FROM
    order = nested_dissection(P).order if dissect else bandwidth_order(P)
    A = _lower_triangle(P, order)
    given = {"p": matrix(np.arange(len(order)))} if dissect else {}
    cholmod.options.update(supernodal=2, nmethods=(1 + many) * dissect)  # to try, `given` first; 0 is the default
    symbolic = cholmod.symbolic(A, **given)
    cholmod.options["nmethods"] = 0  # the default
    return _factorised(P, A, order, symbolic)


def _again(P: sp.csr_matrix, order: np.ndarray, symbolic: Any) -> Factor:
    return _factorised(P, _lower_triangle(P, order), order, symbolic)


def _factorised(P: sp.csr_matrix, A: spmatrix, order: np.ndarray, symbolic: Any) -> Factor:
    try:
        cholmod.numeric(A, symbolic)
    except ArithmeticError as error:
        raise FactorisationFailed(f"CHOLMOD: not positive definite ({error})") from error

    def solve(b: np.ndarray) -> np.ndarray:
        # Sparse right-hand sides go through the factor four at a time, dense ones one by one: a third of the time.
        x = cholmod.spsolve(symbolic, sparse(matrix(np.asfortranarray(b.reshape(len(b), -1)))))
        return np.asarray(matrix(x)).reshape(b.shape)

    again = partial(_again, order=order, symbolic=symbolic)
    return Factor("cvxopt", len(order), P.indices, reordered(order, solve), again=again)


def _lower_triangle(P: sp.csr_matrix, order: np.ndarray) -> spmatrix:
    """Lower triangle of the symmetric matrix P[order, order]."""
    n, rank = len(order), inverse_permutation(order)
    rows, columns = rank.take(P.indices), rank.repeat(np.diff(P.indptr))
    lower = np.flatnonzero(rows >= columns)
    index = (matrix(which.take(lower)) for which in (rows, columns))
    return spmatrix(matrix(P.data.take(lower)), *index, (n, n))
