"""Systems of two unknowns a vertex, solved by conjugate gradients to a given accuracy."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from ...errors import FactorisationFailed
from .base import Factor
from .conjugate_gradients import conjugate_gradients
from .row_blocks import by_rows


def block_jacobi(P: sp.csr_matrix) -> Factor:
    """A matrix, preconditioned by its 2 x 2 blocks, so that the axes at a vertex make no difference."""
    (a, c), b = P.diagonal().reshape(-1, 2).T, P.diagonal(1)[::2]
    det = a * c - b * b
    if not min(a.min(), det.min()) > 0.0:
        raise FactorisationFailed("the matrix is not positive definite")
    blocks, n = np.stack((c, -b, -b, a), axis=1) / det[:, None], len(det)
    inverse = sp.bsr_matrix((blocks.reshape(n, 2, 2), np.arange(n), np.arange(n + 1))).tocsr()

    def refined(b: np.ndarray, accuracy: float) -> np.ndarray:
        return conjugate_gradients(by_rows(P), lambda r, _: (inverse @ r.T).T, b.T.copy(), accuracy).T

    return Factor("block-jacobi", 2 * n, P.indices, inverse.__matmul__, refined=refined)
