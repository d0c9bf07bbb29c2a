"""CHOLMOD through cvxopt: the same as through scikit-sparse, with wheels for every system, under the GPL."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import scipy.sparse as sp
from cvxopt import cholmod, matrix, sparse, spmatrix

from ...errors import FactorisationFailed
from .base import Factor, reordered
from .ordering import bandwidth_order, nested_dissection, renumbered

#: From here on a dissection takes no longer than minimum degree, and on folded surfaces it fills less.
_DISSECT_FROM = 100_000
#: Columns of a matrix that are made at once: what cvxopt takes beside them then is memory that others have freed.
_COLUMNS = 1 << 16


def build(P: sp.csc_matrix) -> Factor:
    """Factorise `P`; raise FactorisationFailed where it is not positive definite."""
    dissect = P.shape[0] >= _DISSECT_FROM
    order = nested_dissection(P.T).order if dissect else bandwidth_order(P.T)
    A = _lower_triangle(P, order)
    given = {"p": matrix(np.arange(len(order)))} if dissect else {}  # the only order that CHOLMOD is to try
    cholmod.options.update(supernodal=2, nmethods=len(given))
    symbolic = cholmod.symbolic(A, **given)
    cholmod.options["nmethods"] = 0  # the default
    return _factorised(P, order, A, np.array(A.V, dtype=np.int32).ravel() - 1, symbolic)


def _factorised(P: sp.csc_matrix, order: np.ndarray, A: spmatrix, source: np.ndarray, symbolic: Any) -> Factor:
    A.V = matrix(P.data.take(source))
    try:
        cholmod.numeric(A, symbolic)
    except ArithmeticError as error:
        raise FactorisationFailed(f"CHOLMOD: not positive definite ({error})") from error

    def solve(b: np.ndarray) -> np.ndarray:
        # Sparse right-hand sides go through the factor four at a time, dense ones one by one: a third of the time.
        x = cholmod.spsolve(symbolic, sparse(matrix(np.asfortranarray(b.reshape(len(b), -1)))))
        return np.asarray(matrix(x)).reshape(b.shape)

    again = partial(_factorised, order=order, A=A, source=source, symbolic=symbolic)
    return Factor("cvxopt", len(order), P.indices, reordered(order, solve), again=again)


def _lower_triangle(P: sp.csc_matrix, order: np.ndarray) -> spmatrix:
    """Lower triangle of the symmetric matrix P[order, order]; its entries are where those of P are stored, from 1."""
    # From 1, because `sparse` drops zeros.
    n = len(order)
    A = renumbered(sp.csr_matrix((np.arange(1, P.nnz + 1, dtype=np.int32), P.indices, P.indptr), shape=P.shape), order)
    blocks = []
    for k in range(0, n, _COLUMNS):
        ends = A.indptr[k : k + _COLUMNS + 1]
        part = slice(ends[0], ends[-1])
        rows, columns = A.indices[part], np.arange(len(ends) - 1, dtype=np.int32).repeat(np.diff(ends))
        lower = np.flatnonzero(rows >= columns + k)
        source, i, j = (matrix(index.take(lower)) for index in (A.data[part], rows, columns))
        blocks.append([spmatrix(source, i, j, (n, len(ends) - 1), "d")])
    return sparse(blocks)
