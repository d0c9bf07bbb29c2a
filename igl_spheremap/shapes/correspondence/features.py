"""Features of two mapped surfaces: smoothed on the surfaces themselves, and compared on the sphere."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from ...errors import check_list
from ...features.feature_surface import FeatureSurface, check_varies
from ...mesh.arrays import FloatArray, check_values, own_unit
from ...resampling.locate import locator_of
from ...sphere.rows import row_crosses, row_lengths, weighted_sum
from ..harmonics.basis import expand
from ..harmonics.rotation import RotationCandidate, best_rotations
from .fits import IterateListener, SphereFunction, fit_moebius
from .levels import Level

_ENDS = "source", "target"


def smooth_function(level: Level, values: FloatArray) -> SphereFunction:
    """Make a function on the sphere of values (n, k) over a surface; its gradients, too, are linear in the faces."""
    x, f = level.map.sphere, level.map.faces
    a, b, c = (x[f[:, k]] for k in range(3))
    normal = row_crosses(b - a, c - a)
    area = row_lengths(normal)  # twice the face's
    unit = normal / np.where(area > 0, area, 1.0)[:, None]
    # The area times the gradient within a face, averaged at vertices by area.
    rises = values[f[:, 1:]] - values[f[:, :1]]
    slopes = np.einsum(
        "mks,msd->mkd",
        rises.transpose(0, 2, 1),
        np.stack((row_crosses(unit, a - c), row_crosses(unit, b - a)), axis=1),
    )
    around = sp.csr_array(
        (np.ones(f.size), (f.ravel(), np.repeat(np.arange(len(f)), 3))), shape=(len(x), len(f))
    )
    total = around @ area
    mean = (around @ slopes.reshape(len(f), -1)) / np.where(total > 0, total, 1.0)[:, None]
    mean = mean.reshape(len(x), -1, 3)
    mean -= np.einsum("nkd,nd->nk", mean, x)[:, :, None] * x[:, None]
    columns, whole = values.shape[1], np.column_stack((values, mean.reshape(len(x), -1)))

    def at(y: FloatArray) -> tuple[FloatArray, FloatArray]:
        there, gradients = np.split(level.at(y, whole), [columns], axis=1)
        return there, gradients.reshape(len(y), columns, 3)

    return at


class FeaturePair:
    """Features of two surfaces, by the width of their smoothing: columns of mean 0 and variance 1.

    Parameters
    ----------
    source, target : Level
        The surfaces on their own meshes.
    given : (the source's values, the target's values), optional
        Data over their vertices; the depth potential of that width without them.
    widths : sequence of float
        Those in use.
    """

    def __init__(
        self,
        source: Level,
        target: Level,
        given: tuple[ArrayLike, ArrayLike] | None,
        widths: Sequence[float],
    ) -> None:
        self._levels = source, target
        self._surfaces = FeatureSurface(source.map.mesh), FeatureSurface(target.map.mesh)
        surfaces = self._surfaces
        self.weights = surfaces[0].areas / surfaces[0].areas.sum()
        self._by_width: dict[float, list[FloatArray]] = {}
        if given is None:
            for width in widths:
                self._by_width[width] = [
                    s.standardize(s.potential(width)[:, None]) for s in surfaces
                ]
            for values, name in zip(self._by_width[widths[0]], _ENDS, strict=True):
                check_varies(values, f"depths of the {name}")
            pairs = zip(*self._by_width.values(), strict=True)
            self._raw = [np.column_stack(columns) for columns in pairs]
        else:
            checked = _checked(given, (len(source.map.sphere), len(target.map.sphere)))
            data = list(zip(surfaces, checked, strict=True))
            for width in widths:
                self._by_width[width] = [s.standardize(s.diffuse(own, width)) for s, own in data]
            self._raw = [s.standardize(own) for s, own in data]

    def smoothed(self, width: float = 0.15) -> list[Level]:
        """Return both surfaces with positions smoothed by that width: depths of folds differ between bodies."""
        return [
            replace(level, metric=surface.diffuse(surface.v, width))
            for level, surface in zip(self._levels, self._surfaces, strict=True)
        ]

    def source(self, widths: Sequence[float]) -> FloatArray:
        """The source's features, at its own vertices."""
        return np.column_stack([self._by_width[width][0] for width in widths])

    def target(self, widths: Sequence[float]) -> SphereFunction:
        """The target's features."""
        values = np.column_stack([self._by_width[width][1] for width in widths])
        return smooth_function(self._levels[1], values)

    def rotations(
        self, width: float, most: int = 4, band: int = 32, oversampling: float = 2.0
    ) -> list[RotationCandidate]:
        """Rotations of the source's sphere with the best agreement of features of one width, the best first.

        Band 32 has steps of 5.6 degrees, which Newton's method refines.
        """
        source, target = (
            expand(locator_of(level.map), values, band, oversampling)
            for level, values in zip(self._levels, self._by_width[width], strict=True)
        )
        return best_rotations(target, source, band, most)

    def fit_moebius(
        self, x: FloatArray, width: float, listener: IterateListener = lambda *_: None
    ) -> FloatArray:
        """Move the source's vertices by the Moebius map that brings features of one width nearest."""
        f = self._levels[0].map.faces
        return fit_moebius(x, f, self.weights, self.source([width]), self.target([width]), listener)

    def correlation(self, x: FloatArray) -> FloatArray:
        """Correlate each feature, as given or of each width, over the source's area; its vertices lie at x."""
        target = self._levels[1].at(x, self._raw[1])
        centred = target - weighted_sum(self.weights, target)
        return weighted_sum(self.weights, centred * self._raw[0]) / np.sqrt(
            weighted_sum(self.weights, centred**2)
        )


def _checked(given: tuple[ArrayLike, ArrayLike], sizes: tuple[int, int]) -> list[FloatArray]:
    """Check that values are finite, not constant, and of the same columns; return them, each column in its own unit."""
    names = [f"features of the {name}" for name in _ENDS]
    both = check_list(given, "features", 2)
    checked = [
        check_values(each, n, name) for each, n, name in zip(both, sizes, names, strict=True)
    ]
    for each, name in zip(checked, names, strict=True):
        check_varies(each, name)
    k, other = (each.shape[1] for each in checked)
    if k != other:
        raise ValueError(
            f"{names[0]} have {k} columns but {names[1]} {other}; give the same ones of both"
        )
    return [np.column_stack([own_unit(column)[0] for column in each.T]) for each in checked]
