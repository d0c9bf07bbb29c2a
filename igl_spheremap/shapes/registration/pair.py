"""Two mapped surfaces and their features, smoothed alike at several widths."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ...mesh.arrays import FloatArray, check_values
from ...mesh.check import check_mesh
from ...result.sphere_map import SphereMap
from ..harmonics.transform import expand
from ..locate import SphereLocator
from ..transfer import transfer
from .correlation import Candidate, best_rotations
from .features import FeatureSurface, check_varies
from .picture import Picture

_DEGREE = 48  # of the fixed features: the narrowest smoothing, 0.04 radians, leaves a seventh at this degree
_BAND = 32  # of the correlation over rotations: steps of 5.6 degrees, refined by Newton's method
_OVERSAMPLING = 2.0  # finer grids change no registration


def _surface(result: SphereMap) -> FeatureSurface:
    return FeatureSurface(check_mesh(result.vertices, result.faces))


class Pair:
    """The moving and the fixed surface; features are columns of mean 0 and variance 1 at each width."""

    def __init__(
        self, moving: SphereMap, fixed: SphereMap, features: tuple[ArrayLike, ArrayLike] | None, widths: list[float]
    ) -> None:
        self._moving = moving
        surfaces = _surface(moving), _surface(fixed)
        self.weights = surfaces[0].areas / surfaces[0].areas.sum()
        values = _features(surfaces, features)
        self._raw = tuple(s.standardize(each) for s, each in zip(surfaces, values, strict=True))
        self.features, smooth = (
            [s.standardize(s.diffuse(raw, width)) for width in widths]
            for s, raw in zip(surfaces, self._raw, strict=True)
        )
        self._locator = SphereLocator(fixed.sphere, fixed.faces)
        self._coefficients = expand(self._locator, np.concatenate(smooth, axis=1), _DEGREE, _OVERSAMPLING)

    def picture(self, level: int) -> Picture:
        """The fixed features at one width."""
        return Picture(self._columns(level))

    def rotations(self) -> list[Candidate]:
        """Rotations of the moving sphere for which the features of the first width agree best."""
        moving = SphereLocator(self._moving.sphere, self._moving.faces)
        coefficients = expand(moving, self.features[0], _BAND, _OVERSAMPLING)
        return best_rotations(self._columns(0), coefficients, _BAND)

    def correlation(self, x: FloatArray) -> FloatArray:
        """Of each feature as it was given, over the moving surface's area, when its sphere is x."""
        fixed = transfer(self._raw[1], self._locator, x)
        centred = fixed - self.weights @ fixed
        return np.asarray(self.weights @ (centred * self._raw[0]) / np.sqrt(self.weights @ centred**2))

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
