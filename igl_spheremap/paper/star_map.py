"""The Gauss map, and the star map of Theorem 2 by the weighted Laplace-Beltrami eigenproblem."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import igl
import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike
from scipy.linalg import eigh
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from ..errors import FactorisationFailed
from ..gate import takes_mesh
from ..mesh.arrays import TINY, FloatArray, check_directions
from ..mesh.check import Mesh, check_mesh
from ..mesh.measure import (
    enclosed_volume,
    fill_directions,
    vertex_areas,
    vertex_normals,
    without_direction,
)
from ..operators.factor.factorize import factorize
from ..operators.laplacian import laplacian_and_notes
from ..sphere.rows import row_dots, weighted_sum

#: Shift of the inverse iteration, below the spectrum 0, 2, 2, 2, 6, ... for A - sigma B_u to have a Cholesky factor.
_SIGMA = -0.5
#: Radians, the root mean square over the image: a map within half a radian of its star map has the shape of a sphere.
_NEAR = 0.5
#: Added to the image's mass matrix, whose sum is 4 pi, for vertices without any.
_RIDGE = 1e-13
#: Most projections: with limbs too deep for float64 they do not settle.
_PROJECTIONS = 20


@takes_mesh
def gauss_map(v: ArrayLike, f: ArrayLike) -> FloatArray:
    """Gauss map: each vertex goes to its unit normal, Definition 1.

    Parameters
    ----------
    v, f : (n, 3) and (m, 3) array_like
        The mesh, as of `check_mesh`.

    Returns
    -------
    (n, 3) float64 array
        Unit rows: libigl's area-weighted vertex normals. If all faces around a vertex have no area, the mean of its
        neighbours' normals stands in.

    Raises
    ------
    MeshError
        If `v, f` is not a closed genus-0 mesh.

    References
    ----------
    Lai et al., Definition 1.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    >>> ism.gauss_map(v, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])[0].round(3)
    array([0.577, 0.577, 0.577])
    """
    mesh = check_mesh(v, f)
    return vertex_normals(mesh.unit, mesh.f)


@dataclass(frozen=True, eq=False)
class EigenProjection:
    """The first three nontrivial eigenfunctions of equation (20) and the star map that they make.

    Attributes
    ----------
    star_map : (n, 3) float64 array
        Unit rows, Theorem 2; turned to agree best with the map that gave the weights; never inside out.
    phi : (n, 3) float64 array
        Eigenfunctions, orthonormal in B_u, turned like the star map. On the sphere, ``|phi|^2`` = 3 / (4 pi).
    eigenvalues : (3,) float64 array
        Ascending; 2, 2, 2 if the weights are those of a conformal map to the unit sphere.
    floored : int
        Vertices whose weight e^{2u} was infinite, and is the largest finite one, or was raised to 1e-12 of the mean.
    undirected : int
        Vertices whose phi is c of eq. (19), which take the direction of their neighbours.
    """

    star_map: FloatArray
    phi: FloatArray
    eigenvalues: FloatArray
    floored: int = 0
    undirected: int = 0

    def __repr__(self) -> str:
        values = ", ".join(f"{value:.3g}" for value in self.eigenvalues)
        return f"EigenProjection({len(self.phi)} vertices, eigenvalues {values})"


@takes_mesh
def weighted_eigen_projection(v: ArrayLike, f: ArrayLike, x: ArrayLike) -> EigenProjection:
    """Solve the eigenproblem weighted by the conformal factor of `x`, and take the star map.

    Parameters
    ----------
    v, f : (n, 3) and (m, 3) array_like
        The mesh, as of `check_mesh`.
    x : (n, 3) array_like
        A map to the unit sphere, with or without foldings.

    Returns
    -------
    EigenProjection
        Star map, eigenfunctions and eigenvalues.

    Raises
    ------
    MeshError
        If `v, f` is not a closed genus-0 mesh, or `x` has not one finite, nonzero row per vertex.
    FactorisationFailed
        If the eigenproblem can't be solved, as on flat surfaces.

    References
    ----------
    Lai et al., eqs. (20), (25)-(27) and Theorem 2.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("sphere", n_vertices=600)
    >>> projection = ism.weighted_eigen_projection(v, f, v)
    >>> projection.eigenvalues.round(1)
    array([2., 2., 2.])
    >>> ism.certify(projection.star_map, f).folding_free
    True
    """
    mesh = check_mesh(v, f)
    return project(mesh, stiffness(mesh), check_directions(x, len(mesh.v), "images"))


def stiffness(mesh: Mesh) -> sp.csr_matrix:
    """Stiffness matrix A, which is the Laplacian."""
    return laplacian_and_notes(mesh)[0]  # eq. (26)


def weighted_mass(mesh: Mesh, weight: FloatArray) -> sp.csr_matrix:
    """Mass matrix B_u of eq. (26) for a weight e^{2u} that is linear on each face, integrated exactly.

    >>> import igl_spheremap as ism
    >>> mesh = ism.check_mesh(*ism.samples.make("sphere", n_vertices=600))
    >>> float(round(weighted_mass(mesh, np.full(len(mesh.v), 4 * np.pi)).sum() / (4 * np.pi), 9))
    1.0
    """
    # Over a face the hat functions e_i e_j e_k have the integral area / 60 times 6 (all equal), 2 (two equal) or 1 (all
    # different), and e_i e_j have M_ij. So 5 B_ij is (w_i + w_j) M_ij, plus the M_ij of faces whose areas are
    # multiplied by the sums of their weights.
    # eq. (23)
    M, W = igl.massmatrix(mesh.unit, mesh.f, igl.MASSMATRIX_TYPE_FULL), sp.diags_array(weight)
    sides = igl.edge_lengths(mesh.unit, mesh.f) * np.sqrt(weight[mesh.f].sum(axis=1))[:, None]
    grown = igl.massmatrix_intrinsic(sides, mesh.f, igl.MASSMATRIX_TYPE_FULL)
    return sp.csr_matrix((grown + (W @ M + M @ W)) / 5)  # eq. (26)


def project(
    mesh: Mesh, A: sp.csr_matrix, x: FloatArray, B: sp.csr_matrix | None = None
) -> EigenProjection:
    """`weighted_eigen_projection` of a checked mesh and map, with a stiffness matrix A.

    Another mass matrix than that of the conformal factor of `x` may be given; in it the mean of phi is 0.
    """
    c, areas, floored = np.zeros(3), None, 0
    if B is None:
        areas = vertex_areas(mesh.unit, mesh.f)
        factor, floored = finite_conformal_factor(mesh, x)
        B = weighted_mass(mesh, factor)
    values, phi = _lowest_eigenpairs(A, B)  # eq. (20)
    if areas is not None:
        c = areas @ phi / areas.sum()  # eq. (19)
    star = fill_directions(phi - c, mesh.f)  # Theorem 2
    R = _agreement(phi, x, B, mirrored=enclosed_volume(star, mesh.f) < 0)
    undirected = int(without_direction(phi - c).sum())
    return EigenProjection(star @ R, phi @ R, values, floored, undirected)


def project_unweighted(
    mesh: Mesh, A: sp.csr_matrix, x: FloatArray, centred: Callable[[FloatArray], FloatArray]
) -> EigenProjection:
    """Project with the weight e^{2u} = 1, then each star map, until a projection moves it by less than `_NEAR`.

    Here e^{2u} is constant on each face, for fewer foldings: B_u is the mass matrix of the image, and has no floor.
    """
    full = igl.MASSMATRIX_TYPE_FULL
    found = project(mesh, A, x, sp.csr_matrix(igl.massmatrix(mesh.unit, mesh.f, full)))
    ridge = sp.diags_array(_RIDGE * mesh.A)
    for _ in range(_PROJECTIONS):
        before = centred(found.star_map)
        found = project(
            mesh, A, before, sp.csr_matrix(igl.massmatrix(before, mesh.f, full) + ridge)
        )
        after = centred(found.star_map)
        areas = vertex_areas(after, mesh.f)
        square = weighted_sum(areas, row_dots(after - before, after - before)) / areas.sum()
        if square < _NEAR**2:
            break
    return found


def finite_conformal_factor(mesh: Mesh, x: FloatArray) -> tuple[FloatArray, int]:
    """Conformal factor e^{2u} of eq. (14), made finite and positive for B_u, and the number of vertices changed.

    Vertices without source area get the largest finite value, and none is below 1e-12 of the mean: B_u stays definite.
    """
    image, source = vertex_areas(x, mesh.f), vertex_areas(mesh.unit, mesh.f)
    factor = np.divide(image, source, out=np.zeros_like(image), where=source > 0)  # eq. (14)
    infinite = (source == 0) & (image > 0)
    factor[infinite] = factor.max(initial=1.0)
    least = 1e-12 * max(float(factor.mean()), TINY)
    return np.maximum(factor, least), int((infinite | (factor < least)).sum())


def _lowest_eigenpairs(A: sp.csr_matrix, B: sp.csr_matrix) -> tuple[FloatArray, FloatArray]:
    """First three nontrivial pairs of A x = lambda B_u x, eq. (27), by shift-invert Lanczos iteration."""
    n = A.shape[0]
    if n <= 8:  # too small for Lanczos: ARPACK keeps nine vectors for four pairs
        values, vectors = eigh(A.toarray(), B.toarray())
        return values[1:4], vectors[:, 1:4]
    P = (A - _SIGMA * B).tocsr()
    factor = factorize(P)
    inverse = LinearOperator((n, n), matvec=factor.solve, dtype=np.float64)
    start = np.ones(n) + np.sin(np.arange(n))  # fixed, so that every run gives the same numbers
    try:
        values, vectors = eigsh(A, k=4, M=B, sigma=_SIGMA, OPinv=inverse, v0=start)  # eq. (27)
    except ArpackError as error:
        raise FactorisationFailed(f"the eigenproblem can't be solved: {error}") from error
    order = np.argsort(values)
    return values[order][1:], vectors[:, order][:, 1:]


def _agreement(phi: FloatArray, x: FloatArray, B: sp.csr_matrix, mirrored: bool) -> FloatArray:
    """Orthogonal matrix that turns `phi` to `x`, a reflection if `phi` turns the surface inside out.

    Eigenfunctions are given up to an orthogonal matrix. Whether to reflect is not decided by the agreement with `x`: if
    half of that map is folded, its mirror image agrees as well.
    """
    u, _, vt = np.linalg.svd(phi.T @ (B @ x))
    handed = np.sign(np.linalg.det(u) * np.linalg.det(vt))
    if mirrored:
        handed = -handed
    u[:, -1] *= handed
    return np.asarray(u @ vt)
