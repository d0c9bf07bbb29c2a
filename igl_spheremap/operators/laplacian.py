"""Cotangent Laplacians of a closed triangle mesh, assembled as positive semidefinite sparse matrices."""

from __future__ import annotations

from typing import Literal

import igl
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..mesh.check import Mesh
from ..mesh.measure import vertex_areas

FloatArray = NDArray[np.float64]

Weights = Literal["cotangent", "mollified", "delaunay", "uniform"]

# Slack in the triangle inequality that mollification enforces, relative to the mean edge length.
MOLLIFY_FACTOR = 1e-5

# A half cotangent above this stems from an angle under 5e-9, where rounding decides its size.
LARGEST_USABLE_WEIGHT = 1e8

#: Smallest vertex area, in units of the mean, that the L2 metric divides by: slivers may have none at all.
_LEAST_AREA = 1e-9
#: The source has unit area, but where its area is rounding: vertices on a line count alike.
_LEAST_TOTAL = 1e-6


def cotangent_laplacian(v: np.ndarray, f: np.ndarray) -> sp.csr_matrix:
    """Assemble the cotangent Laplacian ``L`` of a closed triangle mesh.

    ``x . (L x) / 2`` is the Dirichlet energy of a piecewise linear function ``x``: the weights of eq. (6),
    with the sign that makes the matrix positive semidefinite.

    Parameters
    ----------
    v : (n, 3) float64 ndarray
        Vertex positions.
    f : (m, 3) int64 ndarray
        Faces, as vertex indices.

    Returns
    -------
    (n, n) scipy.sparse.csr_matrix of float64
        ``-igl.cotmatrix(v, f)``: exactly symmetric, with row sums of zero up to rounding, sorted indices
        and an explicit diagonal. Faces of zero area leave entries that are not finite: see `is_usable`.

    References
    ----------
    Lai, Wen, Yin, Gu, Lui (2014), *Folding-Free Global Conformal Mapping for Genus-0 Surfaces by Harmonic
    Energy Minimization*, eq. (6). Pinkall and Polthier (1993), *Computing Discrete Minimal Surfaces and
    Their Conjugates*.

    Examples
    --------
    >>> v, f = igl.icosahedron()
    >>> L = cotangent_laplacian(v, f)
    >>> L.shape, float(abs(L.sum(axis=1)).max()) < 1e-15
    ((12, 12), True)
    """
    return _assemble(igl.cotmatrix_entries(v, f), f, len(v))


def laplacian(v: np.ndarray, f: np.ndarray, weights: Weights = "cotangent") -> sp.csr_matrix:
    """Assemble a Laplacian by the name of its weights.

    Parameters
    ----------
    v : (n, 3) float64 ndarray
        Vertex positions.
    f : (m, 3) int64 ndarray
        Faces of a closed manifold mesh.
    weights : {"cotangent", "mollified", "delaunay", "uniform"}
        ``"cotangent"`` is the mesh's own `cotangent_laplacian`. ``"mollified"`` takes the cotangents from
        `mollified_edge_lengths`, which makes slivers and faces of zero area harmless and changes nothing
        elsewhere. ``"delaunay"`` flips the mollified mesh's edges, intrinsically, until it is Delaunay, so
        that no weight is negative; its pattern differs from the mesh's.

    Returns
    -------
    (n, n) scipy.sparse.csr_matrix of float64
        Symmetric, with row sums of zero up to rounding.

    Raises
    ------
    ValueError
        If `weights` is no known name.

    References
    ----------
    Sharp and Crane (2020), *A Laplacian for Nonmanifold Triangle Meshes*. Fisher, Springborn, Schroeder,
    Bobenko (2007), *An Algorithm for the Construction of Intrinsic Delaunay Triangulations*.

    Examples
    --------
    >>> v, f = igl.icosahedron()
    >>> float(abs(laplacian(v, f, "delaunay") - laplacian(v, f)).max()) < 1e-15
    True
    """
    if weights == "cotangent":
        return cotangent_laplacian(v, f)
    if weights == "mollified":
        return _assemble(igl.cotmatrix_entries(mollified_edge_lengths(v, f)), f, len(v))
    if weights == "delaunay":
        lengths, faces = igl.intrinsic_delaunay_triangulation(mollified_edge_lengths(v, f), f)[:2]
        return _assemble(igl.cotmatrix_entries(lengths), faces, len(v))
    if weights == "uniform":
        return _assemble(np.full(f.shape, 0.5), f, len(v))
    raise ValueError(f"unknown weights {weights!r}: choose 'cotangent', 'mollified', 'delaunay' or 'uniform'")


def mollified_edge_lengths(v: np.ndarray, f: np.ndarray, factor: float = MOLLIFY_FACTOR) -> np.ndarray:
    """Edge lengths with the least common increase that keeps every triangle inequality strict.

    Parameters
    ----------
    v : (n, 3) float64 ndarray
        Vertex positions.
    f : (m, 3) int64 ndarray
        Faces.
    factor : float
        Slack demanded of ``l_j + l_k - l_i``, relative to the mean edge length.

    Returns
    -------
    (m, 3) float64 ndarray
        Length of the edge opposite each corner; the plain lengths where every face has the slack already.

    References
    ----------
    Sharp and Crane (2020), *A Laplacian for Nonmanifold Triangle Meshes*, section 4.5.

    Examples
    --------
    >>> v, f = igl.icosahedron()
    >>> bool((mollified_edge_lengths(v, f) == igl.edge_lengths(v, f)).all())
    True
    """
    lengths = igl.edge_lengths(v, f)
    slack = (lengths.sum(axis=1) - 2.0 * lengths.max(axis=1)).min()
    return lengths + max(0.0, factor * lengths.mean() - slack)


def usable_laplacian(v: np.ndarray, f: np.ndarray) -> sp.csr_matrix:
    """Assemble the mesh's own Laplacian, or the mollified one where slivers or faces of zero area spoil it.

    Parameters
    ----------
    v : (n, 3) float64 ndarray
        Vertex positions.
    f : (m, 3) int64 ndarray
        Faces of a closed manifold mesh.

    Returns
    -------
    (n, n) scipy.sparse.csr_matrix of float64
        With entries that are finite.

    Examples
    --------
    >>> is_usable(usable_laplacian(*igl.icosahedron()))
    True
    """
    L = cotangent_laplacian(v, f)
    return L if is_usable(L) else laplacian(v, f, "mollified")


def is_usable(L: sp.csr_matrix) -> bool:
    """Tell whether a Laplacian's entries are finite and of a size that a factorisation bears.

    Parameters
    ----------
    L : (n, n) sparse matrix
        As from `cotangent_laplacian`.

    Returns
    -------
    bool
        False where slivers or faces of zero area made the cotangents meaningless: take ``"mollified"`` or
        ``"delaunay"`` weights then.

    Examples
    --------
    >>> is_usable(cotangent_laplacian(*igl.icosahedron()))
    True
    """
    return bool(np.abs(L.data).max() < LARGEST_USABLE_WEIGHT)  # a NaN compares as False


def _assemble(half_cotangents: np.ndarray, f: np.ndarray, n: int) -> sp.csr_matrix:
    """Sum half cotangents, each belonging to the edge opposite a corner, into a Laplacian."""
    index = f.T.astype(np.int32, order="C")
    rows = np.concatenate([index[1], index[2], index[0], np.arange(n, dtype=np.int32)])
    columns = np.concatenate([index[2], index[0], index[1], np.arange(n, dtype=np.int32)])
    values = np.concatenate([-half_cotangents.T.ravel(), np.zeros(n)])
    L = sp.csr_matrix((values, (rows, columns)), shape=(n, n))
    # The two faces of an edge of a closed mesh run through it both ways: L and its transpose share their
    # pattern, and a sum of data, unlike that of matrices, keeps entries that happen to be zero. It
    # commutes: exact symmetry.
    with np.errstate(invalid="ignore"):  # infinities of opposite sign: see `is_usable`
        L.data += L.T.tocsr().data
        on_diagonal = np.flatnonzero(L.indices == np.repeat(np.arange(n, dtype=np.int32), np.diff(L.indptr)))
        # The old diagonal is that of loops, which intrinsic flips can make, and which carry no energy.
        L.data[on_diagonal] -= np.add.reduceat(L.data, L.indptr[:-1])
    return L


def positive_areas(mesh: Mesh) -> FloatArray:
    """Vertex areas, none of them vanishing.

    Parameters
    ----------
    mesh : Mesh
        The checked source.

    Returns
    -------
    (n,) float64 array
        A_i of eq. (13), raised to a billionth of their mean where they are smaller; their sum is 1.
    """
    A = vertex_areas(mesh.v, mesh.f)
    total = A.sum()
    if total < _LEAST_TOTAL:
        return np.full(len(A), 1 / len(A))
    A = np.maximum(A, _LEAST_AREA * total / len(A))
    return np.asarray(A / A.sum())

