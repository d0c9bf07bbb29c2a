"""One interface over sparse symmetric positive definite factorisations."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec

import numpy as np
import scipy.sparse as sp

from ..errors import FactorisationFailed
from .base import Factor

__all__ = ["Factor", "FactorisationFailed", "available_backends", "factorize"]

# Backend name: the module that it needs, the file here that drives it. The fastest measured comes first.
_BACKENDS = {
    "scikit-sparse": ("sksparse.cholmod", "scikit_sparse"),
    "cvxopt": ("cvxopt.cholmod", "cvxopt_cholmod"),
    "multifrontal": ("scipy.linalg", "multifrontal"),
    "cholespy": ("cholespy", "cholespy_cholmod"),
    "pypardiso": ("pypardiso", "pardiso"),
    "scipy": ("scipy.sparse.linalg", "scipy_superlu"),
}


def available_backends() -> tuple[str, ...]:
    """Names of the factorisations that can be used here, the one that ``"auto"`` prefers first.

    Returns
    -------
    tuple of str
        Always contains ``"scipy"``, which needs nothing beyond scipy.

    Examples
    --------
    >>> "scipy" in available_backends()
    True
    """
    return tuple(name for name, (needs, _) in _BACKENDS.items() if _installed(needs))


def factorize(P: sp.spmatrix, backend: str = "auto") -> Factor:
    """Factorise a sparse symmetric positive definite matrix.

    Parameters
    ----------
    P : (n, n) sparse matrix of float64
        Symmetric; both triangles stored.
    backend : str
        One of `available_backends`, or ``"auto"`` for the first of them.

    Returns
    -------
    Factor
        Its `solve` applies the inverse; its `backend` tells which one was taken.

    Raises
    ------
    ValueError
        If `backend` is unknown or not installed.
    FactorisationFailed
        If `P` is not finite or not numerically positive definite.

    Examples
    --------
    >>> factor = factorize(sp.diags_array([2.0, 4.0]), backend="scipy")
    >>> factor.solve(np.array([1.0, 1.0])).tolist(), factor.backend
    ([0.5, 0.25], 'scipy')
    """
    P = sp.csc_matrix(P)
    available = available_backends()
    if backend == "auto":
        backend = available[0]
    elif backend not in _BACKENDS:
        raise ValueError(f"unknown backend {backend!r}: choose 'auto' or one of {', '.join(_BACKENDS)}")
    elif backend not in available:
        raise ValueError(f"backend {backend!r} needs {_BACKENDS[backend][0]}, which is not installed")
    if not np.isfinite(P.data).all():
        raise FactorisationFailed("the matrix has entries that are not finite")
    build: Callable[[sp.csc_matrix], Factor] = import_module(f".{_BACKENDS[backend][1]}", __name__).build
    return build(P)


def _installed(module: str) -> bool:
    try:
        return find_spec(module) is not None
    except ModuleNotFoundError:
        return False
