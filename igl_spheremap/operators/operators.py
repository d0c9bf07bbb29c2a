"""The Laplacian of a mesh, factorised once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ..errors import FactorisationFailed
from ..mesh.check import Mesh
from ..mesh.edges import Indices
from ..mesh.timings import stage
from .factor import Factor, factorize
from .laplacian import Weights, is_usable, laplacian

#: P = L + this times M: enough to factorise, too little to be seen.
_REGULARISATION = 1e-9


@dataclass(frozen=True, eq=False)
class Operators:
    """L, and P^-1 for P = L + 1e-9 M."""

    L: sp.csr_matrix
    factor: Factor
    weights: Weights
    notes: tuple[str, ...] = ()  # why the weights are not the first choice


@stage("Laplacian")
def build_operators(mesh: Mesh, backend: str = "auto", like: Operators | None = None) -> Operators:
    """Assemble and factorise the Laplacian with cotangent weights, or with the first more robust ones that allow it.

    The operators `like` these, of the same faces at other positions, are lost: their order and memory are used again.

    Raises FactorisationFailed if even uniform weights can't be, for want of memory.
    """
    notes: list[str] = []
    order: tuple[Weights, ...] = ("cotangent", "mollified", "delaunay", "uniform")
    for choice in order:
        L = laplacian(mesh.v, mesh.f, choice, mesh.edges)
        if not is_usable(L):
            notes.append(f"{choice} weights are not usable: slivers or faces of zero area")
            continue
        diagonal = _diagonal(L, mesh, choice)
        kept = L.data[diagonal]
        L.data[diagonal] += _REGULARISATION * mesh.A  # P, in the memory of L: factors keep the pattern only
        try:
            factor = factorize(L, backend, like.factor if like else None)
        except FactorisationFailed:
            if choice == "uniform":
                raise
            notes.append(f"{choice} weights are not positive definite: obtuse slivers")
            continue
        L.data[diagonal] = kept
        break
    return Operators(L, factor, choice, tuple(notes))


def _diagonal(L: sp.csr_matrix, mesh: Mesh, weights: Weights) -> Indices:
    """Entries on the diagonal; flips change the mesh's own pattern."""
    if weights != "delaunay":
        return mesh.edges.diagonal
    rows = np.arange(L.shape[0], dtype=np.int32).repeat(np.diff(L.indptr))
    return np.flatnonzero(L.indices == rows).astype(np.int32)
