"""SuperLU as it comes with scipy: a Cholesky in all but name, through its symmetric mode without pivoting."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import splu

from ..errors import FactorisationFailed
from .base import Factor


def build(P: sp.csc_matrix) -> Factor:
    """Factorise `P`; raise FactorisationFailed where a pivot is zero or the result not finite."""
    order = reverse_cuthill_mckee(P, symmetric_mode=True)
    try:
        lu = splu(
            P[order][:, order],
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True, "Equil": False},
        )
    except RuntimeError as error:
        raise FactorisationFailed(f"SuperLU: {error}") from error

    def apply(b: np.ndarray) -> np.ndarray:
        x = np.empty_like(b)
        x[order] = lu.solve(b[order])
        return x

    return Factor("scipy", P.shape[0], apply, nnz=lu.nnz)
