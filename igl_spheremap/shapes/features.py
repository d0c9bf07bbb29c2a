"""Features of two mapped surfaces: data smoothed on the surface itself, and compared on the sphere."""

from __future__ import annotations

from functools import cached_property

import igl
import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from ..errors import MeshError
from ..mesh.arrays import FloatArray, check_values
from ..mesh.check import Mesh
from ..operators.factor.factorize import factorize
from ..operators.laplacian import usable_laplacian
from ..result.sphere_map import SphereMap
from ..sphere.rows import weighted_sum
from .basis import degree_of, expand, gauss_rows, grid_synthesis
from .grid import from_grid
from .locate import SphereLocator
from .rotation import RotationCandidate, best_rotations, turning
from .transfer import transfer

_DEPTH = 0.6  # radians that the surface is smoothed by to distinguish outward folds from inward ones
_NOISE = 0.16  # radians that curvature is smoothed by: below, that of a marching-cubes mesh is noise
_DEGREE = 48  # of the fixed features: the narrowest smoothing, 0.04 radians, leaves a seventh at this degree
_BAND = 32  # of the correlation over rotations: steps of 5.6 degrees, refined by Newton's method
_OVERSAMPLING = 2.0  # finer grids change no registration
_CONSTANT = 1e-12  # spread of values, as a share of the largest, that is rounding
_ROWS_PER_DEGREE = 3  # the error of bilinear lookup is 6 percent at the highest degree, and goes with its square below


class FeatureSurface:
    """A surface of area 4 pi, as large as its sphere: lengths on it are comparable to radians."""

    def __init__(self, mesh: Mesh) -> None:
        self.v, self.f = mesh.v * np.sqrt(4 * np.pi), mesh.f
        self.areas = 4 * np.pi * mesh.areas
        self.L = usable_laplacian(mesh)

    def diffuse(self, values: FloatArray, sigma: float, steps: int = 2) -> FloatArray:
        """Implicit heat steps that together smooth by a Gaussian of that width."""
        factor = factorize(sp.csr_matrix(self.L * (sigma**2 / (2 * steps)) + sp.diags_array(self.areas)))
        for _ in range(steps):
            values = np.stack([factor.solve(self.areas * column) for column in values.T], axis=1)
        return values

    def standardize(self, values: FloatArray) -> FloatArray:
        """Mean 0 and variance 1 over the area."""
        weights = self.areas / self.areas.sum()
        centred = values - weighted_sum(weights, values)
        return np.asarray(centred / np.sqrt(weighted_sum(weights, centred**2)))

    @cached_property
    def geometry(self) -> FloatArray:
        """Curvature and depth (n, 2), standardised."""
        return self.standardize(np.stack((self._curvature(), self.depth(_DEPTH)), axis=1))

    def _curvature(self) -> FloatArray:
        """Arctangent of the mean curvature, so that tips and creases do not outweigh the rest."""
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
    constant = np.flatnonzero(spread <= _CONSTANT * np.abs(values).max(axis=0))
    if len(constant):
        raise MeshError(f"{name} are constant in column {constant[0]}; give data that vary over the surface")


class GridFunction:
    """The function with coefficients ((L + 1)^2, k), by a fine grid: a call gives values (n, k) and gradients."""

    def __init__(self, c: FloatArray) -> None:
        rows = _ROWS_PER_DEGREE * (degree_of(c) + 1)
        coefficients = np.concatenate((c, *turning(c)), axis=1)  # x cross grad is band-limited, too
        self._grid = grid_synthesis(coefficients, gauss_rows(rows)[0], 2 * rows)
        self._columns = c.shape[1]

    def __call__(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        read = from_grid(self._grid, x, "gauss")
        values, turns = np.split(read, [self._columns], axis=1)
        across = turns.reshape(len(x), 3, -1).transpose(0, 2, 1)
        return values, np.cross(across, x[:, None])  # (x cross grad) cross x = grad


class SurfacePair:
    """The moving and the fixed surface; features are columns of mean 0 and variance 1 at each width."""

    def __init__(
        self, moving: SphereMap, fixed: SphereMap, features: tuple[ArrayLike, ArrayLike] | None, widths: list[float]
    ) -> None:
        self._moving = moving
        surfaces = FeatureSurface(moving.mesh), FeatureSurface(fixed.mesh)
        self.weights = surfaces[0].areas / surfaces[0].areas.sum()
        values = _features(surfaces, features)
        self._raw = tuple(s.standardize(each) for s, each in zip(surfaces, values, strict=True))
        self.features, smooth = (
            [s.standardize(s.diffuse(raw, width)) for width in widths]
            for s, raw in zip(surfaces, self._raw, strict=True)
        )
        self._locator = SphereLocator(fixed)
        self._coefficients = expand(self._locator, np.concatenate(smooth, axis=1), _DEGREE, _OVERSAMPLING)

    def fixed_features(self, level: int) -> GridFunction:
        """The fixed surface's features at one width."""
        return GridFunction(self._columns(level))

    def rotations(self) -> list[RotationCandidate]:
        """Rotations of the moving sphere for which the features of the first width agree best."""
        moving = SphereLocator(self._moving)
        coefficients = expand(moving, self.features[0], _BAND, _OVERSAMPLING)
        return best_rotations(self._columns(0), coefficients, _BAND)

    def correlation(self, x: FloatArray) -> FloatArray:
        """Correlation of each feature as it was given, over the moving surface's area, if its sphere is x."""
        fixed = transfer(self._locator, self._raw[1], x)
        centred = fixed - weighted_sum(self.weights, fixed)
        return weighted_sum(self.weights, centred * self._raw[0]) / np.sqrt(weighted_sum(self.weights, centred**2))

    def _columns(self, level: int) -> FloatArray:
        k = self.features[0].shape[1]
        return self._coefficients[:, level * k : (level + 1) * k]


def _features(
    surfaces: tuple[FeatureSurface, FeatureSurface], features: tuple[ArrayLike, ArrayLike] | None
) -> tuple[FloatArray, FloatArray]:
    """The given features, checked, or those of the geometry."""
    if features is None:
        return surfaces[0].geometry, surfaces[1].geometry
    names = "features of the moving surface", "features of the fixed surface"
    checked = tuple(check_values(each, len(s.v), name) for each, s, name in zip(features, surfaces, names, strict=True))
    for each, name in zip(checked, names, strict=True):
        check_varies(each, name)
    moving, fixed = checked
    if moving.shape[1] != fixed.shape[1]:
        raise ValueError(f"{moving.shape[1]} moving but {fixed.shape[1]} fixed features; give the same ones of both")
    return moving, fixed
