"""Features: data over a surface, smoothed on the surface itself and therefore independent of its map."""

from __future__ import annotations

from functools import cached_property

import igl
import numpy as np
import scipy.sparse as sp

from ...errors import MeshError
from ...mesh.arrays import FloatArray
from ...mesh.check import Mesh
from ...operators.factor import factorize
from ...operators.laplacian import usable_laplacian

_DEPTH = 0.6  # radians that the surface is smoothed by to distinguish outward folds from inward ones
_NOISE = 0.16  # radians that curvature is smoothed by: below, that of a marching-cubes mesh is noise


class FeatureSurface:
    """A surface of area 4 pi, as large as its sphere: lengths on it are comparable to radians."""

    def __init__(self, mesh: Mesh) -> None:
        self.v, self.f = mesh.v * np.sqrt(4 * np.pi), mesh.f
        self.areas = 4 * np.pi * mesh.A
        self.L = usable_laplacian(mesh)

    def diffuse(self, values: FloatArray, sigma: float, steps: int = 2) -> FloatArray:
        """Implicit heat steps that together smooth by a Gaussian of that width."""
        factor = factorize(sp.csr_matrix(self.L * (sigma**2 / (2 * steps)) + sp.diags_array(self.areas)))
        for _ in range(steps):
            values = np.stack([factor.solve(self.areas * column) for column in values.T], axis=1)
        return values

    def standardize(self, values: FloatArray) -> FloatArray:
        """Mean 0 and variance 1 over the area."""
        centred = values - self.areas @ values / self.areas.sum()
        return np.asarray(centred / np.sqrt(self.areas @ centred**2 / self.areas.sum()))

    @cached_property
    def geometry(self) -> FloatArray:
        """Curvature and depth (n, 2), standardised."""
        return self.standardize(np.stack((self._curvature(), self.depth(_DEPTH)), axis=1))

    def _curvature(self) -> FloatArray:
        """Mean curvature, squashed so that tips and creases do not outweigh the rest."""
        normals = np.asarray(igl.per_vertex_normals(self.v, self.f))
        curvature = np.einsum("ij,ij->i", self.L @ self.v, normals) / (2 * self.areas)
        return self.diffuse(np.arctan(curvature / 2)[:, None], _NOISE, steps=1)[:, 0]

    def depth(self, sigma: float) -> FloatArray:
        """How far the surface lies outside of itself smoothed by that width."""
        smooth = self.diffuse(self.v, sigma, steps=1)
        return np.einsum("ij,ij->i", self.v - smooth, np.asarray(igl.per_vertex_normals(smooth, self.f)))


def check_varies(values: FloatArray, name: str) -> None:
    """Raise a MeshError if a column is constant: it carries no information on position."""
    spread = np.ptp(values, axis=0)
    constant = np.flatnonzero(spread <= 1e-12 * np.abs(values).max(axis=0))
    if len(constant):
        raise MeshError(f"{name} are constant in column {constant[0]}; give data that vary over the surface")
