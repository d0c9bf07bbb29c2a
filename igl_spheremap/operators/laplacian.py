"""Laplacians of a closed triangle mesh: positive semidefinite sparse matrices, one of which is factorised."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import igl
import numpy as np
import scipy.sparse as sp

from ..errors import FactorisationFailed, MapError, Remedy
from ..mesh.arrays import FloatArray, IntArray, count, examples
from ..mesh.check import Mesh
from ..mesh.edges import HalfEdges, Indices, half_edges
from ..mesh.measure import by_libigl, rounding_notes
from ..timings import phase
from .factor.factorize import Factor, factorize
from .factor.ordering import breadth_first
from .flips import delaunay_triangulation

#: "cotangent" are the mesh's own weights, eq. (13). "mollified" takes them from `mollified_edge_lengths`, which differ
#: only on meshes with slivers or faces of zero area. "delaunay" flips edges of the mollified mesh, intrinsically, until
#: no weight is negative; the pattern differs from the mesh's. "uniform" gives each edge the weight 1.
Weights = Literal["cotangent", "mollified", "delaunay", "uniform"]

#: A half cotangent above this stems from an angle under 5e-9, where rounding decides its size.
LARGEST_USABLE_WEIGHT = 1e8
#: Cause of unusable weights, for notes.
_SPOILT = "slivers or faces of zero area"


def laplacian(
    v: FloatArray, f: IntArray, weights: Weights = "cotangent", edges: HalfEdges | None = None
) -> sp.csr_matrix:
    """The Laplacian L with the weights of that name: ``x . (L x) / 2`` is the energy of a piecewise linear x, eq. (6).

    It is exactly symmetric, with sorted indices and an explicit diagonal. "cotangent" is ``-igl.cotmatrix(v, f)``
    (Pinkall and Polthier 1993, *Computing Discrete Minimal Surfaces and Their Conjugates*) but for rounding, in less
    time: the mesh's check has found its pattern already.
    Faces of zero area leave entries that are not finite there: see `is_usable`. `edges`, computed if not given, are the
    matrix's pattern, except for "delaunay", whose flips change it.

    Sharp and Crane 2020, *A Laplacian for Nonmanifold Triangle Meshes*.

    >>> v, f = igl.icosahedron()
    >>> float(abs(laplacian(v, f, "delaunay") - laplacian(v, f)).max()) < 1e-15
    True
    """
    if edges is None:
        edges = half_edges(f, len(v))
    assert edges is not None, "the mesh is not closed"
    if weights == "delaunay":
        lengths, faces = delaunay_triangulation(mollified_edge_lengths(v, f), edges)
        return summed_laplacian(igl.cotmatrix_entries(lengths), faces, len(v))
    if weights == "cotangent":
        weight = by_libigl(igl.cotmatrix_entries, v, f)  # algorithm (1)
    elif weights == "mollified":
        weight = igl.cotmatrix_entries(mollified_edge_lengths(v, f))
    else:
        weight = np.full(f.shape, 0.5)
    return _assemble(weight, edges)


def cotangent_laplacian(mesh: Mesh) -> sp.csr_matrix:
    """L of the paper's algorithms, by libigl."""
    return _negated(igl.cotmatrix(mesh.unit, mesh.f))  # eq. (13), of the other sign


def delaunay_laplacian(mesh: Mesh) -> sp.csr_matrix:
    """L of the intrinsic Delaunay triangulation, by libigl; if no weight of the mesh is negative, L of the mesh."""
    L = cotangent_laplacian(mesh)
    if is_usable(L) and (L.data > 0).sum() <= len(mesh.v):  # the diagonal alone is positive
        return L
    lengths, faces = delaunay_triangulation(mollified_edge_lengths(mesh.unit, mesh.f), mesh.edges)
    return _negated(igl.cotmatrix_intrinsic(lengths, faces))


def _negated(L: sp.csc_matrix) -> sp.csr_matrix:
    # it is symmetric: its columns are its rows
    return sp.csr_matrix((-L.data, L.indices, L.indptr), shape=L.shape)


def printed_laplacian(mesh: Mesh) -> sp.csr_matrix:
    """L of eq. (13) as it is; a MapError if it is not finite."""
    L = cotangent_laplacian(mesh)
    if np.isfinite(L.data).all():
        return L
    bad = np.flatnonzero(
        ~np.isfinite(by_libigl(igl.cotmatrix_entries, mesh.unit, mesh.f)).all(axis=1)
    )
    raise MapError(
        f"the cotangent weights of eq. (13) are not finite at {count(bad, 'face')} without area, "
        f"{examples(bad)}; remove such faces, or take {Remedy(options={'edge_weights': 'delaunay'})}"
    )


def mollified_edge_lengths(v: FloatArray, f: IntArray) -> FloatArray:
    """(m, 3) lengths of the edges opposite the corners, plus the least number that gives triangle inequalities slack.

    The slack is 1e-5 of the mean edge length; if every face has it already, the lengths stay. Sharp and Crane 2020,
    section 4.5.

    >>> v, f = igl.icosahedron()
    >>> bool((mollified_edge_lengths(v, f) == igl.edge_lengths(v, f)).all())
    True
    """
    lengths = by_libigl(igl.edge_lengths, v, f)
    slack = (lengths.sum(axis=1) - 2.0 * lengths.max(axis=1)).min()
    return lengths + max(0.0, 1e-5 * lengths.mean() - slack)


def usable_laplacian(mesh: Mesh, weights: Weights = "cotangent") -> sp.csr_matrix:
    """The Laplacian with those weights, or, if slivers or faces of zero area spoil it, the mollified one."""
    L = laplacian(mesh.unit, mesh.f, weights, mesh.edges)
    if is_usable(L):
        return L
    return laplacian(mesh.unit, mesh.f, "mollified", mesh.edges)


def laplacian_and_notes(
    mesh: Mesh, weights: Weights = "cotangent"
) -> tuple[sp.csr_matrix, tuple[str, ...]]:
    """The Laplacian with those weights by libigl; if they are not usable, the mollified one and a note."""
    if weights == "cotangent":
        L = cotangent_laplacian(mesh)
    elif weights == "delaunay":
        L = delaunay_laplacian(mesh)
    else:
        L = laplacian(mesh.unit, mesh.f, weights, mesh.edges)
    if is_usable(L):
        return L, ()
    return laplacian(mesh.unit, mesh.f, "mollified", mesh.edges), (
        f"{weights} weights are not usable: {_SPOILT}",
    )


def apply_laplacian(L: sp.csr_matrix, x: FloatArray) -> FloatArray:
    """L x in the layout of x."""
    y = np.empty_like(x)
    for k in range(x.shape[1]):
        y[:, k] = L @ x[:, k]
    return y


def is_usable(L: sp.csr_matrix) -> bool:
    """True if the entries are finite and below 1e8 in size, as those of slivers may not be."""
    return bool(max(L.data.max(), -L.data.min()) < LARGEST_USABLE_WEIGHT)  # a NaN compares as False


def _assemble(weight: FloatArray, edges: HalfEdges) -> sp.csr_matrix:
    """Sum half cotangents, each belonging to the half-edge opposite a corner; entries that sum to zero are kept."""
    w, n = weight.ravel(), len(edges.diagonal)
    with np.errstate(invalid="ignore"):  # infinities of opposite sign: see `is_usable`
        data = w.take(edges.half, mode="clip")
        data += w.take(edges.twin, mode="clip")  # it commutes: exact symmetry
        np.negative(data, out=data)
        data[edges.diagonal] = 0.0
        data[edges.diagonal] = -np.add.reduceat(data, edges.indptr[:-1])
    return sp.csr_matrix((data, edges.indices, edges.indptr), shape=(n, n))


def summed_laplacian(weight: FloatArray, f: IntArray, n: int) -> sp.csr_matrix:
    """The Laplacian of any triangles: with a boundary, loops (which have no energy) or multiple edges."""
    opposite = np.roll(f, -1, axis=1).ravel(), np.roll(f, -2, axis=1).ravel()
    W = sp.csr_matrix((weight.ravel(), opposite), shape=(n, n))
    W = W + W.T
    return (sp.diags(np.asarray(W.sum(axis=1)).ravel()) - W).tocsr()


@dataclass(frozen=True, eq=False)
class Operators:
    """L, and P^-1 for P = L + 1e-9 M.

    L is singular: constants are in its kernel. Relative to M, of sum 1, its other eigenvalues begin at 8 pi on a round
    sphere, so that they change in the tenth digit only.
    """

    L: sp.csr_matrix
    factor: Factor
    weights: Weights
    notes: tuple[str, ...] = ()  # why the weights, or positions, are poor


@phase("Laplacian")
def build_operators(mesh: Mesh, backend: str = "auto", reuse: Operators | None = None) -> Operators:
    """Assemble and factorise the Laplacian with cotangent weights, or with the first more robust ones that allow it.

    `reuse` are operators of the same faces at other positions. Their order and memory are used again; further use of
    their factor raises.

    If memory does not suffice even for uniform weights, it raises FactorisationFailed.
    """
    notes, before = rounding_notes(mesh.v, mesh.f), None
    if reuse is not None:
        before = reuse.factor
    choices: tuple[Weights, ...] = ("cotangent", "mollified", "delaunay", "uniform")
    for choice in choices:
        L = laplacian(mesh.unit, mesh.f, choice, mesh.edges)
        if not is_usable(L):
            notes.append(f"{choice} weights are not usable: {_SPOILT}")
            continue
        diagonal = _diagonal(L, mesh, choice)
        kept = L.data[diagonal]
        # algorithm (2), in the memory of L: factors keep the pattern only
        L.data[diagonal] += 1e-9 * mesh.A
        try:
            factor = factorize(L, backend, before, breadth_first)
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
