"""The Laplacian of a mesh, factorised once: the metric in which the fast map moves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..errors import FactorisationFailed
from ..mesh.check import Mesh
from .factor import Factor, factorize
from .laplacian import Weights, is_usable, laplacian, positive_areas

FloatArray = NDArray[np.float64]

#: P = L + this times M: enough to factorise, too little to be seen.
_REGULARISATION = 1e-9


@dataclass(frozen=True, eq=False)
class Operators:
    """L, the vertex areas, and P^-1 for P = L + 1e-9 M.

    Attributes
    ----------
    L : (n, n) sparse matrix
        Laplacian, positive semidefinite.
    P : (n, n) sparse matrix
        What is factorised, L + 1e-9 M.
    A : (n,) float64 array
        Vertex areas, none vanishing, of sum 1.
    factor : Factor
        Applies P^-1.
    weights : str
        Which Laplacian it is, see `laplacian`.
    notes : tuple of str
        Why it is not the plain one, where it is not.
    """

    L: sp.csr_matrix
    P: sp.csr_matrix
    A: FloatArray
    factor: Factor
    weights: Weights
    notes: tuple[str, ...] = ()


def build_operators(mesh: Mesh, backend: str = "auto", weights: Weights = "cotangent") -> Operators:
    """Assemble and factorise, with other weights where the mesh's own do not bear it.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    backend : str
        Factorisation, see `factorize`.
    weights : {"cotangent", "mollified", "delaunay", "uniform"}
        First choice.

    Returns
    -------
    Metric
        Its notes say which choice was passed over, and why.

    Raises
    ------
    ValueError
        If `backend` is unknown or not installed.
    FactorisationFailed
        If even uniform weights can't be factorised, for want of memory.
    """
    A = positive_areas(mesh)
    notes: list[str] = []
    order: tuple[Weights, ...] = ("cotangent", "mollified", "delaunay", "uniform")
    for choice in order[order.index(weights):]:
        L = laplacian(mesh.v, mesh.f, choice)
        if not is_usable(L):
            notes.append(f"{choice} weights are not usable: slivers or faces of zero area")
            continue
        P = L + sp.diags_array(_REGULARISATION * A, format="csr")
        try:
            factor = factorize(P, backend)
        except FactorisationFailed:
            if choice == "uniform":
                raise
            notes.append(f"{choice} weights are not positive definite: obtuse slivers")
            continue
        break
    return Operators(L, P, A, factor, choice, tuple(notes))
