"""Sparse symmetric positive definite solvers behind one function. If you're not sure which one to use, take "auto"."""

from __future__ import annotations

from functools import cache
from importlib import import_module

import scipy.sparse as sp

from ...timings import phase
from .factor import Analysis, Cholmod, Entries, Factor, Rslab, SuperLU, check_definite
from .memory import OF_SOLVER, bytes_left, too_little
from .ordering import Numbering, bandwidth_order

#: The module that each solver needs, and its class, the fastest first.
_SOLVERS: dict[str, tuple[str, type[Analysis]]] = {
    "cvxopt": ("cvxopt.cholmod", Cholmod),
    "rslab": ("rslab", Rslab),
    "scipy": ("scipy.sparse.linalg", SuperLU),
}


def available_backends() -> tuple[str, ...]:
    """Names of the solvers that are installed and work in this process, the fastest first; "scipy" always does."""
    return tuple(
        name
        for name, (needs, analysis) in _SOLVERS.items()
        if _loads(needs) and not analysis.waits()
    )


@phase("factorisation")
def factorize(
    P: sp.spmatrix,
    backend: str = "auto",
    reuse: Factor | None = None,
    numbering: Numbering = bandwidth_order,
) -> Factor:
    """Factorise a symmetric positive definite matrix with both triangles stored.

    "auto" takes the fastest solver that is installed. `reuse` is a factor that this function made. If its matrix had
    the same pattern, its order and memory are used again; then its further use raises.

    Raises ValueError for a backend that is unknown or not installed, and FactorisationFailed for a matrix that is
    not finite or not numerically positive definite.

    >>> import numpy as np
    >>> factor = factorize(sp.diags_array([2.0, 4.0]), backend="scipy")
    >>> factor.solve(np.array([1.0, 1.0])).tolist(), factor.backend
    ([0.5, 0.25], 'scipy')
    """
    if P.format == "csc":
        P = P.T  # in rows; it is symmetric
    else:
        P = sp.csr_matrix(P)
    backend = _chosen(backend)
    if reuse is not None and reuse.backend == backend and reuse.analysis.entries.are_of(P):
        analysis = reuse.analysis
    else:
        analysis = _SOLVERS[backend][1](Entries.of(P, numbering))
    factor = analysis.factorize(P.data)
    if isinstance(analysis, SuperLU):
        check_definite(P, factor)
    return factor


def analyse(entries: Entries, backend: str = "auto") -> Analysis:
    """A solver for matrices of one pattern that are factorised again and again.

    Raises ValueError for a backend that is unknown or not installed.
    """
    return _SOLVERS[_chosen(backend)][1](entries)


def _chosen(backend: str) -> str:
    available = available_backends()
    if not available:
        raise too_little(OF_SOLVER["scipy.sparse.linalg"])
    if backend == "auto":
        return available[0]
    if backend not in _SOLVERS:
        raise ValueError(
            f"unknown backend {backend!r}: choose 'auto' or one of {', '.join(_SOLVERS)}"
        )
    if backend not in available:
        needs, analysis = _SOLVERS[backend]
        why = f"needs {needs}, which is not installed; install it"
        if analysis.waits():
            why = (
                "does not work in a process forked from one that used it; start processes by spawn"
            )
        raise ValueError(
            f"backend {backend!r} {why}, or choose {' or '.join(map(repr, available))}"
        )
    return backend


@cache
def _loads(module: str) -> bool:
    """Whether a module is installed, and the system gives its libraries their memory."""
    if bytes_left() < OF_SOLVER[module]:
        return False
    try:
        import_module(module)
    except ImportError:
        return False
    return True
