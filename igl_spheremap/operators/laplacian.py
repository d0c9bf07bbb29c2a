"""Laplacians of a closed triangle mesh, assembled as positive semidefinite sparse matrices."""

from __future__ import annotations

from typing import Literal

import igl
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..mesh.check import Mesh
from ..mesh.measure import vertex_areas
from .flips import delaunay_triangulation

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: "cotangent" are the mesh's own weights, eq. (6). "mollified" takes them from `mollified_edge_lengths`, which changes
#: nothing but slivers and faces of zero area. "delaunay" flips edges of the mollified mesh, intrinsically, until no
#: weight is negative; the pattern differs from the mesh's. "uniform" gives each edge the weight 1.
Weights = Literal["cotangent", "mollified", "delaunay", "uniform"]

#: Slack in the triangle inequality that mollification enforces, relative to the mean edge length.
MOLLIFY_FACTOR = 1e-5
#: A half cotangent above this stems from an angle under 5e-9, where rounding decides its size.
LARGEST_USABLE_WEIGHT = 1e8
#: Smallest vertex area, in units of the mean, that the L2 metric divides by: slivers may have none at all.
_LEAST_AREA = 1e-9
#: The source has unit area, but where its area is rounding: vertices on a line count alike.
_LEAST_TOTAL = 1e-6


def cotangent_laplacian(v: FloatArray, f: IntArray) -> sp.csr_matrix:
    """The cotangent Laplacian L: ``x . (L x) / 2`` is the Dirichlet energy of a piecewise linear x, eq. (6).

    It is ``-igl.cotmatrix(v, f)``, exactly symmetric, with sorted indices and an explicit diagonal (Pinkall and
    Polthier 1993, *Computing Discrete Minimal Surfaces and Their Conjugates*). Faces of zero area leave entries that
    are not finite: see `is_usable`.

    >>> v, f = igl.icosahedron()
    >>> L = cotangent_laplacian(v, f)
    >>> L.shape, float(abs(L.sum(axis=1)).max()) < 1e-15
    ((12, 12), True)
    """
    return _assemble(igl.cotmatrix_entries(v, f), f, len(v))


def laplacian(v: FloatArray, f: IntArray, weights: Weights = "cotangent") -> sp.csr_matrix:
    """The Laplacian with the weights of that name: symmetric, with row sums of zero up to rounding.

    Sharp and Crane 2020, *A Laplacian for Nonmanifold Triangle Meshes*.

    >>> v, f = igl.icosahedron()
    >>> float(abs(laplacian(v, f, "delaunay") - laplacian(v, f)).max()) < 1e-15
    True
    """
    if weights == "cotangent":
        return cotangent_laplacian(v, f)
    if weights == "mollified":
        return _assemble(igl.cotmatrix_entries(mollified_edge_lengths(v, f)), f, len(v))
    if weights == "delaunay":
        lengths, faces = delaunay_triangulation(mollified_edge_lengths(v, f), f)
        return _assemble(igl.cotmatrix_entries(lengths), faces, len(v))
    if weights == "uniform":
        return _assemble(np.full(f.shape, 0.5), f, len(v))
    raise ValueError(f"unknown weights {weights!r}: choose 'cotangent', 'mollified', 'delaunay' or 'uniform'")


def mollified_edge_lengths(v: FloatArray, f: IntArray, factor: float = MOLLIFY_FACTOR) -> FloatArray:
    """(m, 3) lengths of the edges opposite the corners, all increased alike until each triangle inequality has slack.

    The slack is `factor` times the mean edge length; where every face has it already the lengths stay as they are.
    Sharp and Crane 2020, section 4.5.

    >>> v, f = igl.icosahedron()
    >>> bool((mollified_edge_lengths(v, f) == igl.edge_lengths(v, f)).all())
    True
    """
    lengths = igl.edge_lengths(v, f)
    slack = (lengths.sum(axis=1) - 2.0 * lengths.max(axis=1)).min()
    return lengths + max(0.0, factor * lengths.mean() - slack)


def usable_laplacian(v: FloatArray, f: IntArray) -> sp.csr_matrix:
    """The mesh's own Laplacian, or the mollified one where slivers or faces of zero area spoil it.

    >>> is_usable(usable_laplacian(*igl.icosahedron()))
    True
    """
    L = cotangent_laplacian(v, f)
    return L if is_usable(L) else laplacian(v, f, "mollified")


def is_usable(L: sp.csr_matrix) -> bool:
    """Whether the entries are finite and of a size that a factorisation bears; slivers can make cotangents neither."""
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
    """Vertex areas A_i of eq. (13) with sum 1, none below a billionth of their mean."""
    A = vertex_areas(mesh.v, mesh.f)
    total = A.sum()
    if total < _LEAST_TOTAL:
        return np.full(len(A), 1 / len(A))
    A = np.maximum(A, _LEAST_AREA * total / len(A))
    return np.asarray(A / A.sum())

