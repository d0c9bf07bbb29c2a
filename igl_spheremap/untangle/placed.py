"""Where a body lies in the plane, how deep each vertex is on the sphere, and the way onto the sphere.

A vertex is deep by so many nepers as its edges on the sphere are shorter than those float64 holds everywhere: in a
general position that is the logarithm of their length, beside a pole of the axis that of their length over the distance
from the pole, as coordinates are finer there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..mesh.arrays import ComplexArray, FloatArray, IntArray
from ..mesh.check import Mesh
from ..mesh.measure import log_edges
from ..sphere.charts import to_chart
from ..sphere.gauge import best_rotation, orientation_target
from ..sphere.moebius import conformal_barycentre
from ..sphere.rows import weighted_moment
from .layout import Layout

LongComplex = NDArray[np.clongdouble]
LongFloat = NDArray[np.longdouble]


@dataclass(frozen=True, eq=False)
class Placed:
    """Positions in the plane, by which inverse stereographic projection is to put a body on the sphere."""

    f: IntArray
    z: ComplexArray
    #: Nepers, see above.
    depth: FloatArray
    #: Positions relative to a vertex, precise relative to the distance from it.
    about: Callable[[int], ComplexArray]
    #: What they are taken from, if not from a map.
    layout: Layout | None = None


def centred(layout: Layout, area: FloatArray) -> Placed:
    """Lay out about the deepest vertex; inverse stereographic projection centres the area."""
    unit = _median(layout.log_edge, area)
    z = layout.about(int(np.argmin(layout.log_edge)), unit)
    c = complex(_median(z.real, area), _median(z.imag, area))
    size = _median(np.abs(z - c), area) or float(np.abs(z - c).max())
    z, unit = (z - c) / size, unit + np.log(size)
    # The conformal barycentre is a point (c, size) of the half-space over the plane: an affine map centres it.
    p = conformal_barycentre(to_ball(z.astype(np.clongdouble)).astype(np.float64), area)
    square = p[0] ** 2 + p[1] ** 2 + (1 + p[2]) ** 2
    size = (1 - p @ p) / square
    z, unit = (z - 2 * (p[0] + 1j * p[1]) / square) / size, unit + np.log(size)
    depth = unit + 2 * np.log(np.hypot(1, np.abs(z))) - np.log(2) - layout.log_edge
    return Placed(layout.f, z, depth, lambda tip: layout.about(tip, unit), layout)


def between_poles(layout: Layout, area: FloatArray) -> Placed:
    """Lay out about the deepest vertex, one pole, the hole being the other; half of the area on each side."""
    unit = _median(layout.log_edge, area)
    z = layout.about(int(np.argmin(layout.log_edge)), unit)
    distance = np.log(np.where(z == 0, 1, np.abs(z)))
    middle = _median(distance, area)
    depth = np.where(z == 0, 0, distance + unit - layout.log_edge)
    return Placed(layout.f, z * np.exp(-middle), depth, lambda tip: layout.about(tip, unit + middle), layout)


def as_mapped(x: FloatArray, f: IntArray, pole: FloatArray) -> Placed:
    """A map as it lies in the chart that touches the sphere at a pole."""
    z = to_chart(x, pole)
    return Placed(f, z, -log_edges(x, f), lambda tip: z - z[tip])


def _median(values: FloatArray, area: FloatArray) -> float:
    """The value that halves the area."""
    order = np.argsort(values)
    return float(values[order[np.searchsorted(np.cumsum(area[order]), area.sum() / 2)]])


def onto_sphere(mesh: Mesh, z: LongComplex, area: FloatArray, *, keep_axis: bool = False) -> FloatArray:
    """Unit rows, turned to the package's gauge, or as near as the axis allows, before they are rounded to float64."""
    x = to_ball(z)
    moment = weighted_moment(area, x.astype(np.float64), orientation_target(mesh, area))
    kept = np.ones((3, 3))
    if keep_axis:
        kept[2, :2] = kept[:2, 2] = 0
    turn = best_rotation(np.eye(3), kept * moment, np.ones(3)) * kept
    x = x @ turn.astype(np.longdouble)
    return (x / np.sqrt((x * x).sum(axis=1))[:, None]).astype(np.float64)


def to_ball(z: LongComplex) -> LongFloat:
    """Inverse stereographic projection, 0 to (0, 0, 1), without overflow near infinity."""
    far = np.abs(z) > 1
    u = np.where(far, 1 / np.where(far, z, 1).conj(), z)
    q = u.real**2 + u.imag**2
    height = np.where(far, q - 1, 1 - q)
    return np.column_stack((2 * u.real, 2 * u.imag, height)) / (1 + q)[:, None]
