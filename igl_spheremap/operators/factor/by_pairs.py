"""Systems of two unknowns a vertex, solved by conjugate gradients to a given number of digits."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import cg

from ...errors import FactorisationFailed
from .base import Factor

_MAX_STEPS = 200  # a tenth of the residual takes some 10


def by_pairs(P: sp.csr_matrix) -> Factor:
    """A matrix and, as about its inverse, that of each vertex alone: no axes of the unknowns are preferred."""
    (a, c), b = P.diagonal().reshape(-1, 2).T, P.diagonal(1)[::2]
    det = a * c - b * b
    if not min(a.min(), det.min()) > 0.0:
        raise FactorisationFailed("the matrix is not positive definite")
    blocks, n = np.stack((c, -b, -b, a), axis=1) / det[:, None], len(det)
    inverse = sp.bsr_matrix((blocks.reshape(n, 2, 2), np.arange(n), np.arange(n + 1))).tocsr()

    def refined(r: np.ndarray, accuracy: float) -> np.ndarray:
        return np.column_stack([cg(P, column, rtol=accuracy, maxiter=_MAX_STEPS, M=inverse)[0] for column in r.T])

    return Factor("pairs", P, inverse.__matmul__, refined=refined)
