"""Features of a surface alone: its depth potential, and data smoothed on it."""

from __future__ import annotations

from functools import cached_property

import igl
import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from ..errors import MeshError, check_number
from ..gate import takes_mesh
from ..mesh.arrays import ROUNDING, FloatArray
from ..mesh.check import Mesh, check_mesh
from ..operators.factor.factor import Factor
from ..operators.factor.factorize import factorize
from ..operators.laplacian import usable_laplacian
from ..sphere.rows import weighted_sum


class FeatureSurface:
    """A surface of area 4 pi, as large as its sphere: lengths on it are comparable to radians."""

    def __init__(self, mesh: Mesh) -> None:
        self.v, self.f = mesh.unit * np.sqrt(4 * np.pi), mesh.f
        self.areas = 4 * np.pi * mesh.areas
        self.L = usable_laplacian(mesh)
        self._last: Factor | None = None

    def diffuse(self, values: FloatArray, sigma: float, steps: int = 2) -> FloatArray:
        """Implicit heat steps that together smooth by a Gaussian of that width."""
        factor = self._factor(self.L * (sigma**2 / (2 * steps)) + sp.diags_array(self.areas))
        for _ in range(steps):
            values = np.column_stack([factor.solve(self.areas * column) for column in values.T])
        return values

    def standardize(self, values: FloatArray) -> FloatArray:
        """Mean 0 and variance 1 over the area."""
        weights = self.areas / self.areas.sum()
        centred = values - weighted_sum(weights, values)
        return centred / np.sqrt(weighted_sum(weights, centred**2))

    @cached_property
    def _bending(self) -> FloatArray:
        """Twice the mean curvature times the area at each vertex."""
        return np.einsum(
            "ij,ij->i", self.L @ self.v, np.asarray(igl.per_vertex_normals(self.v, self.f))
        )

    def potential(self, ell: float) -> FloatArray:
        """The depth potential (n,), see `depth_potential`."""
        rest = self._bending - self.areas * (self._bending.sum() / self.areas.sum())
        return self._factor(self.L + sp.diags_array(self.areas / ell**2)).solve(rest)  # shapes (6)

    def _factor(self, P: sp.sparray) -> Factor:
        """The factor of a matrix of the Laplacian's pattern, in the order of the last one."""
        self._last = factorize(sp.csr_matrix(P), reuse=self._last)
        return self._last

    @cached_property
    def curvature_and_depth(self) -> FloatArray:
        """Mean curvature and depth (n, 2), standardised: features of bodies, which depth potentials tell apart less."""
        curvature = self._bending / (2 * self.areas)
        # so that tips and creases do not outweigh the rest
        curvature = np.arctan(curvature / 2)[:, None]
        # below .16 radians the curvature of a marching-cubes mesh is noise; .6 tell outward folds from inward ones
        smooth = self.diffuse(curvature, 0.16, steps=1)
        return self.standardize(np.column_stack((smooth, self.depth(0.6))))

    def depth(self, sigma: float) -> FloatArray:
        """Distance of the surface outside of itself smoothed by that width."""
        smooth = self.diffuse(self.v, sigma, steps=1)
        return np.einsum(
            "ij,ij->i", self.v - smooth, np.asarray(igl.per_vertex_normals(smooth, self.f))
        )


@takes_mesh
def depth_potential(
    v: ArrayLike, f: ArrayLike, *, ell: float = 0.12, caps: ArrayLike | None = None
) -> FloatArray:
    """Depth of a surface's folds, from the surface alone: high on ridges and tips, low in valleys.

    The solution d of ``(L + M / ell^2) d = M (2 H - mean(2 H))``, H the mean curvature: curvature gathered over the
    width `ell`. A wide one tells lobes and limbs apart, .12 is like FreeSurfer's ``sulc`` of a cortex with the sign
    reversed, .05 like its ``curv``.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions; they are scaled to a surface of area 4 pi, so that any units will do.
    f : (m, 3) array_like
        Faces as 0-based vertex indices: closed, oriented, connected, genus 0.
    ell : float, default 0.12
        Width over which curvature is gathered, in lengths of a surface of area 4 pi: radians if it were a sphere.
    caps : (m,) array_like of bool, optional
        Faces that only close holes and cuts, see `check_mesh`: none by default.

    Returns
    -------
    (n,) float64 array
        The potential, of mean 0 over the area.

    Raises
    ------
    MeshError
        If the mesh is invalid.
    ValueError
        If `ell` is below 0.001.

    References
    ----------
    Boucher, Whitesides, Evans 2009, *Depth potential function for folding pattern representation, registration and
    analysis*.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> from igl_spheremap.features.feature_surface import depth_potential
    >>> v, f = ism.samples.make("pear", n_vertices=500)
    >>> int(depth_potential(v, f, ell=0.7).argmax()) == int(v[:, 2].argmax())  # the pear's tip
    True
    """
    check_number(
        ell, "ell", 1e-3
    )  # below, it is less than the edges of any mesh that fits into memory
    return FeatureSurface(check_mesh(v, f, caps=caps)).potential(ell)


def check_varies(values: FloatArray, name: str) -> None:
    """Raise a MeshError if a column is constant: it carries no information on position."""
    halves = 0.5 * values  # the difference of two of them is a float64 number
    # or 0 over 0
    constant = np.flatnonzero(~(np.ptp(halves, axis=0) > ROUNDING * np.abs(halves).max(axis=0)))
    if len(constant):
        raise MeshError(
            f"{name} are constant in column {constant[0]}; give data that vary over the surface"
        )
