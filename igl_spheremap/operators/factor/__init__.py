"""Sparse symmetric positive definite solvers behind one function: one file each, the choice here.

If you're not sure which one to use, take "auto".
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache
from importlib import import_module
from importlib.util import find_spec

import numpy as np
import scipy.sparse as sp

from ...errors import FactorisationFailed
from ...mesh.timings import stage
from .base import Factor

__all__ = ["Factor", "FactorisationFailed", "available_backends", "factorize"]

#: Of each backend the module that it needs and the file here that drives it. The fastest measured comes first.
_BACKENDS = {
    "cvxopt": ("cvxopt.cholmod", "cvxopt_cholmod"),
    "scikit-sparse": ("sksparse.cholmod", "scikit_sparse"),
    "scipy": ("scipy.sparse.linalg", "scipy_superlu"),
    "multigrid": ("scipy.sparse", "multigrid"),
}

#: Memory of a factor and of making it: the most that was measured (SuperLU, 240,000 vertices).
_BYTES_PER_UNKNOWN = 3_000


def available_backends() -> tuple[str, ...]:
    """Names of the solvers that are installed, the fastest first; "scipy" and "multigrid" always are."""
    return tuple(name for name, (needs, _) in _BACKENDS.items() if _installed(needs))


@stage("factorisation")
def factorize(P: sp.spmatrix, backend: str = "auto", like: Factor | None = None, *, many: bool = False) -> Factor:
    """Factorise a symmetric positive definite matrix, of which both triangles are stored.

    "auto" takes the fastest exact solver that is installed; where a factor would take more than half of the machine's
    memory, "multigrid", which only approximates the inverse. If `like` is given, the factor of a matrix with the same
    pattern, its order is used again, and that factor is lost. If `many` are to follow, a solver may search for a
    better order.

    Raises ValueError for a backend that is unknown or not installed, and FactorisationFailed for a matrix that is
    not finite or not numerically positive definite.

    >>> factor = factorize(sp.diags_array([2.0, 4.0]), backend="scipy")
    >>> factor.solve(np.array([1.0, 1.0])).tolist(), factor.backend
    ([0.5, 0.25], 'scipy')
    """
    P = P.T if P.format == "csc" else sp.csr_matrix(P)  # symmetric: its transpose will do
    available = available_backends()
    if backend == "auto":
        backend = _choose(P.shape[0], available)
    elif backend not in _BACKENDS:
        raise ValueError(f"unknown backend {backend!r}: choose 'auto' or one of {', '.join(_BACKENDS)}")
    elif backend not in available:
        raise ValueError(f"backend {backend!r} needs {_BACKENDS[backend][0]}, which is not installed")
    if not np.isfinite(P.data).all():
        raise FactorisationFailed("the matrix has entries that are not finite")
    if like is not None and like.again and like.backend == backend and np.array_equal(like.indices, P.indices):
        return like.again(P)
    build: Callable[[sp.csr_matrix, bool], Factor] = import_module(f".{_BACKENDS[backend][1]}", __name__).build
    return build(P, many)


def _choose(n: int, available: tuple[str, ...]) -> str:
    return "multigrid" if n * _BYTES_PER_UNKNOWN > _memory() / 2 else available[0]


def _memory() -> float:
    """Bytes of the machine's memory, not what is free of it: the choice must not change from run to run."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, ValueError, OSError):
        return float("inf")


@cache
def _installed(module: str) -> bool:
    try:
        return find_spec(module) is not None
    except ModuleNotFoundError:
        return False


# The solver that "auto" takes is imported with this package: 12 ms that the first map of a process does not wait for.
import_module(f".{_BACKENDS[available_backends()[0]][1]}", __name__)
