"""cholespy: a simplicial Cholesky with a fast solve."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from cholespy import CholeskySolverD, MatrixType

from ...errors import FactorisationFailed
from .base import Factor


def build(P: sp.csc_matrix) -> Factor:
    """Factorise `P`; raise FactorisationFailed where it is not positive definite."""
    n = P.shape[0]
    try:
        indptr, indices = P.indptr.astype(np.int32), P.indices.astype(np.int32)
        solver = CholeskySolverD(n, indptr, indices, P.data, MatrixType.CSC)
    except (RuntimeError, ValueError) as error:
        raise FactorisationFailed(f"cholespy: {error}") from error

    def solve(b: np.ndarray) -> np.ndarray:
        x = np.zeros_like(b, order="C")
        solver.solve(np.ascontiguousarray(b), x)
        return x

    return Factor("cholespy", n, solve)
