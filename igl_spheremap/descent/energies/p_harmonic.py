"""The p-harmonic energy of Remark 1, eq. (8)."""

from __future__ import annotations

from dataclasses import dataclass

import igl
import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from ...errors import own_errstate
from ...mesh.arrays import FloatArray, check_rows
from ...mesh.check import Mesh, check_mesh
from ...operators.laplacian import is_usable, laplacian, mollified_edge_lengths
from ...sphere.rows import row_dots


@dataclass(frozen=True, eq=False)
class PHarmonicEnergy:
    """The integral of ``|grad F|^p / p`` over the source, for a map that is linear on each face."""

    #: Exponent above 1; 2 gives the harmonic energy.
    p: float
    #: (3 m, n), takes positions to the vectors along the side opposite each corner.
    sides: sp.csr_matrix
    #: (m, 3), of the source's corners.
    half_cotangents: FloatArray
    #: (m,), of the source's faces, positive.
    areas: FloatArray

    @classmethod
    def of(cls, mesh: Mesh, p: float) -> PHarmonicEnergy:
        """The energy of a mesh, with mollified lengths where its own are unusable; a ValueError unless p is above 1."""
        if not 1 < p < np.inf:
            raise ValueError(f"p = {p:g} is out of range: the p-harmonic energy needs a finite p above 1")
        n, m = len(mesh.v), len(mesh.f)
        usable = is_usable(laplacian(mesh.v, mesh.f, "cotangent", mesh.edges))
        lengths = igl.edge_lengths(mesh.v, mesh.f) if usable else mollified_edge_lengths(mesh.v, mesh.f)
        rows = np.arange(3 * m)
        head, tail = np.roll(mesh.f, -1, axis=1).ravel(), np.roll(mesh.f, -2, axis=1).ravel()
        ones = np.ones(3 * m)
        sides = sp.csr_matrix((np.r_[ones, -ones], (np.r_[rows, rows], np.r_[head, tail])), shape=(3 * m, n))
        areas = np.asarray(igl.doublearea(l=lengths, nan_replacement=0.0)).ravel() / 2
        return cls(p, sides, np.asarray(igl.cotmatrix_entries(lengths)), areas)

    def evaluate(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Value and derivatives: those of the harmonic energy with each face weighted by |grad F|^(p - 2)."""
        side = self.sides @ x
        square = row_dots(side, side).reshape(-1, 3)
        density = np.maximum(row_dots(self.half_cotangents, square) / self.areas, 0.0)  # eq. (5)
        value = float(np.einsum("i,i->", self.areas, density ** (self.p / 2))) / self.p  # eq. (8)
        # Where the map is constant the gradient vanishes for every p > 1, though the weight may be infinite.
        weight = np.power(density, self.p / 2 - 1, out=np.zeros_like(density), where=density > 0)
        side *= (weight[:, None] * self.half_cotangents).reshape(-1, 1)
        return value, self.sides.T @ side


@own_errstate
def p_harmonic_energy(v: ArrayLike, f: ArrayLike, x: ArrayLike, p: float) -> float:
    """p-harmonic energy of a map, equation (8).

    Parameters
    ----------
    v : (n, 3) array_like
        Source positions; the source counts as having unit area, for the energy depends on its scale unless p
        = 2.
    f : (m, 3) array_like
        Faces as 0-based vertex indices.
    x : (n, 3) array_like
        Images of the vertices.
    p : float
        Exponent, above 1.

    Returns
    -------
    float
        At p = 2, the harmonic energy.

    Raises
    ------
    MeshError
        If `v, f` is no closed genus-0 mesh or `x` has not one row per vertex.
    ValueError
        If p is not above 1.

    References
    ----------
    Lai et al., Remark 1 and eq. (8).

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("sphere", n_vertices=600)
    >>> round(ism.p_harmonic_energy(v, f, v, 2) / ism.harmonic_energy(v, f, v), 12)
    1.0
    """
    mesh = check_mesh(v, f)
    return PHarmonicEnergy.of(mesh, p).evaluate(check_rows(x, len(mesh.v), "images"))[0]
