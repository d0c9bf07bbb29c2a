"""Where a body lies in the plane, how deep each vertex is on the sphere, and the way onto the sphere.

The depth of a vertex, in nepers, is minus the logarithm of the length of its edges on the sphere; beside an end of an
axis where a tip lies (poles.py), of their length over the distance from it, as coordinates are finer there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..mesh.arrays import ComplexArray, FloatArray, IntArray
from ..mesh.check import Mesh
from ..mesh.measure import log_edges, weighted_quantile
from ..sphere.gauge import best_rotation, orientation_target
from ..sphere.moebius import conformal_barycentre
from ..sphere.rows import to_chart
from .layout import Layout

LongComplex = NDArray[np.clongdouble]
LongFloat = NDArray[np.longdouble]
AnyComplex = TypeVar("AnyComplex", ComplexArray, LongComplex)


@dataclass(frozen=True, eq=False)
class Placed:
    """Positions in the plane, by which inverse stereographic projection is to put a body on the sphere."""

    f: IntArray
    z: ComplexArray
    #: Of each vertex, in nepers, see above.
    depth: FloatArray
    #: Positions relative to a vertex, precise relative to the distance from it.
    about: Callable[[int], ComplexArray]
    #: The points of the plane that `z` is relative to: 0, or ends of axes, which are 0 or of length 1.
    anchor: ComplexArray | complex = 0j
    #: Rotation of rows that follows inverse stereographic projection.
    turn: FloatArray = field(default_factory=lambda: np.eye(3))


def centred(mesh: Mesh, layout: Layout) -> Placed:
    """Lay out about the deepest vertex; inverse stereographic projection centres the area."""
    area = mesh.A
    unit = weighted_quantile(layout.log_edge, area)
    z = layout.about(int(np.argmin(layout.log_edge)), unit)
    c = complex(weighted_quantile(z.real, area), weighted_quantile(z.imag, area))
    size = weighted_quantile(np.abs(z - c), area) or float(np.abs(z - c).max())
    z, unit = (z - c) / size, unit + np.log(size)
    # The conformal barycentre is a point (c, size) of the half-space over the plane: an affine map centres it.
    p = conformal_barycentre(to_ball(z).astype(np.float64), area)
    square = p[0] ** 2 + p[1] ** 2 + (1 + p[2]) ** 2
    size = (1 - p @ p) / square
    z, unit = (z - 2 * (p[0] + 1j * p[1]) / square) / size, unit + np.log(size)
    depth = unit + 2 * np.log(np.hypot(1, np.abs(z))) - np.log(2) - layout.log_edge
    x = to_ball(z).astype(np.float64)
    turn = best_rotation(x, orientation_target(mesh), area)
    return Placed(layout.f, z, depth, lambda tip: layout.about(tip, unit), turn=turn)


def as_mapped(x: FloatArray, f: IntArray, pole: FloatArray) -> Placed:
    """A map as it lies in the chart that touches the sphere at a pole."""
    z = to_chart(x, pole)
    return Placed(f, z, -log_edges(x, f), lambda tip: z - z[tip])


def onto_sphere(placed: Placed, z: ComplexArray | LongComplex) -> FloatArray:
    """Unit rows at positions relative to the anchors of a placement."""
    x = to_ball(z, placed.anchor) @ placed.turn.astype(np.longdouble)
    return (x / np.sqrt((x * x).sum(axis=1))[:, None]).astype(np.float64)


def to_ball(z: ComplexArray | LongComplex, anchor: ComplexArray | complex = 0j) -> LongFloat:
    """Inverse stereographic projection in long doubles, 0 to (0, 0, 1), without overflow near infinity.

    Beside an anchor, 0 or of length 1, `z` and two of the coordinates keep their relative precision.
    """
    z = from_anchor(z.astype(np.clongdouble), anchor)
    far = np.abs(z) > 1
    u = np.where(far, 1 / np.where(far, z, 1).conj(), z)
    q = u.real**2 + u.imag**2
    x, height = 2 * u / (1 + q), np.where(far, q - 1, 1 - q) / (1 + q)
    along = x * np.conj(anchor)  # and across, as its imaginary part
    plane = np.where(anchor == 0, x, anchor * (height + 1j * along.imag))
    return np.column_stack((plane.real, plane.imag, np.where(anchor == 0, height, -along.real)))


def from_anchor(z: AnyComplex, anchor: ComplexArray | complex) -> AnyComplex:
    """Positions relative to anchors after the rotations of the sphere that take these to 0."""
    return np.asarray(z / (1 + np.abs(anchor) ** 2 + np.conj(anchor) * z))


def plane_angles(z: ComplexArray) -> FloatArray:
    """Signed corner angles of triangles in the plane, (m, 3): negative where folded, 0 where corners coincide."""
    after, before = np.roll(z, -1, axis=1) - z, np.roll(z, 1, axis=1) - z
    return np.angle(before * after.conj())
