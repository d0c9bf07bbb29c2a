"""Stretches of the faces by a piecewise linear map between two surfaces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...mesh.arrays import BoolArray, FloatArray, IntArray, own_unit
from ...mesh.measure import face_areas, weighted_quantile
from ...sphere.rows import row_dots

#: Figures name the share of the area with measures above this: faces that are as good as lost.
LOST = 100.0


@dataclass(frozen=True, eq=False)
class Distortion:
    """Distance of a map between surfaces of equal area from an isometry, face by face of its overlay.

    A face's linear map, after both surfaces were scaled to the same area, has singular values s1 >= s2. All three
    measures are the same for the map and its inverse. If one of the areas is zero, they are infinite.

    Attributes
    ----------
    symmetric_dirichlet : (m,) float64 array
        s1^2 + s2^2 + 1/s1^2 + 1/s2^2; 4 for an isometry.
    area_ratio : (m,) float64 array
        The larger one of s1 s2 and its inverse; 1 if areas are kept.
    angle_ratio : (m,) float64 array
        s1 / s2; 1 if angles are kept.
    source_areas, target_areas : (m,) float64 arrays
        The share of each face in the area of the source and of the target; 0 for those in caps.
    """

    symmetric_dirichlet: FloatArray
    area_ratio: FloatArray
    angle_ratio: FloatArray
    source_areas: FloatArray
    target_areas: FloatArray

    def __repr__(self) -> str:
        a, b = (over["symmetric_dirichlet"] for over in self.figures.values())
        return (
            f"Distortion(symmetric Dirichlet energy, 4 for an isometry: median {a['median']:.3g} over the source, "
            f"{b['median']:.3g} over the target; 95% below {a['p95']:.3g} and {b['p95']:.3g})"
        )

    @classmethod
    def of(
        cls,
        on_source: FloatArray,
        on_target: FloatArray,
        f: IntArray,
        caps: BoolArray | None = None,
    ) -> Distortion:
        """Measure a mesh with positions on both surfaces; caps do not count."""
        on_source, on_target = own_unit(on_source)[0], own_unit(on_target)[0]
        whole = face_areas(on_source, f), face_areas(on_target, f)
        areas = whole
        if caps is not None:
            areas = np.where(caps, 0.0, whole[0]), np.where(caps, 0.0, whole[1])
        with np.errstate(divide="ignore", invalid="ignore"):
            a, b = (
                _sides(p, f) / np.sqrt(area.sum())
                for p, area in zip((on_source, on_target), areas, strict=True)
            )
            # In planes with the first side along the axis, the map is the matrix (p q; 0 r).
            p, r = b[0] / a[0], b[2] / a[2]
            q = (b[1] - p * a[1]) / a[2]
            J, half = p * r, (p**2 + q**2 + r**2) / 2
            root = np.sqrt(np.maximum(half**2 - J**2, 0))
            measures = [2 * half * (1 + 1 / J**2), np.maximum(J, 1 / J), (half + root) / J]
        flat = (whole[0] == 0) | (whole[1] == 0)
        return cls(
            *(np.where(flat, np.inf, measure) for measure in measures),
            *(area / area.sum() for area in areas),
        )

    @property
    def figures(self) -> dict[str, dict[str, dict[str, float]]]:
        """Median, 95 percent and the share of area above 100, as ``figures["over_source"]["angle_ratio"]["median"]``.

        They are taken over the area of the source (``over_source``) and over that of the target (``over_target``).
        """
        names, figures = ("symmetric_dirichlet", "area_ratio", "angle_ratio"), {}
        for end in ("source", "target"):
            areas = getattr(self, f"{end}_areas")
            figures[f"over_{end}"] = {name: _figures(getattr(self, name), areas) for name in names}
        return figures


def _sides(v: FloatArray, f: IntArray) -> FloatArray:
    """Return (3, m): the length of each face's first side, and the third corner's coordinates along and across it."""
    base, side = v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]]
    length = np.sqrt(row_dots(base, base))
    return np.stack((length, row_dots(base, side) / length, 2 * face_areas(v, f) / length))


def _figures(values: FloatArray, areas: FloatArray) -> dict[str, float]:
    """Summarise measures over the faces that have an area."""
    own = areas > 0
    values, areas = values[own], areas[own]
    return {
        "median": weighted_quantile(values, areas),
        "p95": weighted_quantile(values, areas, 0.95),
        f"above_{LOST:g}": float(areas[values > LOST].sum() / areas.sum()),
    }
