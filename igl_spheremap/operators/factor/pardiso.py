"""Intel MKL's PARDISO through pypardiso: the one that gains from threads; x86 only."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from pypardiso import PyPardisoSolver
from pypardiso.pardiso_wrapper import PyPardisoError

from ...errors import FactorisationFailed
from .base import Factor

_SYMMETRIC_POSITIVE_DEFINITE = 2


def build(P: sp.csc_matrix) -> Factor:
    """Factorise `P`; raise FactorisationFailed where it is not positive definite."""
    upper = sp.triu(P, format="csr")
    solver = PyPardisoSolver(mtype=_SYMMETRIC_POSITIVE_DEFINITE)
    try:
        solver.factorize(upper)
    except PyPardisoError as error:
        raise FactorisationFailed(f"PARDISO: {error}") from error

    def solve(b: np.ndarray) -> np.ndarray:
        return np.ascontiguousarray(solver.solve(upper, np.asfortranarray(b)).reshape(b.shape))

    return Factor("pypardiso", P.shape[0], solve)
