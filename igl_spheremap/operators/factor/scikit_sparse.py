"""CHOLMOD through scikit-sparse: supernodal Cholesky with approximate minimum degree."""

from __future__ import annotations

import scipy.sparse as sp
from sksparse.cholmod import CholmodError, cholesky

from ...errors import FactorisationFailed
from .base import Factor, reordered
from .ordering import bandwidth_order, renumbered


def build(P: sp.csr_matrix, many: bool = False) -> Factor:
    """Factorise `P`; raise FactorisationFailed where it is not positive definite."""
    order = bandwidth_order(P)  # a subdivided mesh's own order misleads minimum degree
    try:
        factor = cholesky(renumbered(P, order).T, mode="supernodal", ordering_method="amd")
    except CholmodError as error:
        raise FactorisationFailed(f"CHOLMOD: {error}") from error
    return Factor("scikit-sparse", len(order), P.indices, reordered(order, factor.solve_A))
