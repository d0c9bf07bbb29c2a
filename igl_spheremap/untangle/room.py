"""Making room in float64 for what is laid out beyond it: limbs are shortened about their tips, and put on the sphere.

A limb of length l and circumference c shrinks like exp(-2 pi l / c); on a sphere in float64 edges end at exp(-35).
Where limbs go deeper, log r about each tip is shortened by the profile of least angle differences, twigs first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..mesh.check import Mesh
from ..sphere.gauge import best_rotation, orientation_target
from ..sphere.moebius import conformal_barycentre
from .layout import Layout
from .profile import Limb, choose_kappas

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
LongComplex = NDArray[np.clongdouble]
LongFloat = NDArray[np.longdouble]
IntArray = NDArray[np.int64]

#: Discs of limbs begin where edges are shorter than exp(-this).
_ONSET = 4.0
#: A tip is one of its own if it lies so many nepers deeper than where its limb meets a deeper one.
_PERSISTENCE = 4.0
#: Share of the distance to the nearest vertex outside that a disc takes.
_CLEAR = 0.98
#: A disc of fewer vertices is left as it is: it has no ring to be shortened along.
_LEAST_DISC = 6


@dataclass(frozen=True, eq=False)
class Placed:
    """Positions in the plane by which a body's area is centred, and how deep each vertex lies on the sphere.

    Attributes
    ----------
    layout : Layout
        Of closed angles.
    log_unit : float
        Logarithm of the plane's unit, in the layout's.
    z : (n,) complex array
        Positions in that unit; inverse stereographic projection centres the source's area.
    depth : (n,) float64 array
        Minus the logarithm of the edges' lengths on the sphere.
    """

    layout: Layout
    log_unit: float
    z: ComplexArray
    depth: FloatArray


def centred(layout: Layout, area: FloatArray) -> Placed:
    """Lay out about the deepest vertex, and centre."""
    order = np.argsort(layout.log_edge)
    middle = order[np.searchsorted(np.cumsum(area[order]), area.sum() / 2)]
    unit = float(layout.log_edge[middle])
    z = layout.about(int(order[0]), unit)
    c, size = _medians(z, area)
    z, unit = (z - c) / size, unit + np.log(size)
    # The conformal barycentre is a point (c, size) of the half-space over the plane: an affine map centres it.
    p = conformal_barycentre(to_ball(z.astype(np.clongdouble)).astype(np.float64), area)
    square = p[0] ** 2 + p[1] ** 2 + (1 + p[2]) ** 2
    size = (1 - p @ p) / square
    z, unit = (z - 2 * (p[0] + 1j * p[1]) / square) / size, unit + np.log(size)
    depth = unit + 2 * np.log(np.hypot(1, np.abs(z))) - np.log(2) - layout.log_edge
    return Placed(layout, unit, z, depth)


def _medians(z: ComplexArray, area: FloatArray) -> tuple[complex, float]:
    """Middle of the area by medians, and the median distance from it."""
    def median(values: FloatArray) -> float:
        order = np.argsort(values)
        return float(values[order[np.searchsorted(np.cumsum(area[order]), area.sum() / 2)]])

    c = complex(median(z.real), median(z.imag))
    return c, median(np.abs(z - c)) or float(np.abs(z - c).max())


def make_room(placed: Placed, source: FloatArray, floor: float) -> tuple[LongComplex, float]:
    """Positions in the plane whose edges on the sphere stay above exp(-floor), and the largest ratio by which a
    limb's depth was divided."""
    limbs = _limbs(placed, floor)
    if not limbs:
        return placed.z.astype(np.clongdouble), 1.0
    choose_kappas(limbs, placed.layout.f, source, placed.depth, floor)
    branches = {id(branch) for limb in limbs for branch, _ in limb.branches}
    z = placed.z.astype(np.clongdouble)
    done: dict[int, tuple[IntArray, LongComplex]] = {}  # vertices that a limb moves, and where it puts them
    for limb in limbs:
        w = limb.z.astype(np.clongdouble)
        moved = [limb.disc]
        for branch, _ in limb.branches:
            where, at = done[id(branch)]
            w[where] = limb.z[branch.tip] + at
            moved.append(where)
        other = limb.disc[limb.disc != limb.tip]
        distance = np.log(limb.radius / np.maximum(np.abs(w[other]), np.longdouble(1e-300))).astype(np.float64)
        w[other] *= np.exp((distance - limb.shortened(distance)).astype(np.longdouble))
        where = np.unique(np.concatenate(moved))
        done[id(limb)] = where, w[where]
        if id(limb) not in branches:
            z[where] = placed.z[limb.tip] + w[where]
    return z, float(max(len(limb.kappa) / limb.kappa.sum() for limb in limbs))


def _limbs(placed: Placed, floor: float) -> list[Limb]:
    """Discs about the tips beyond the floor, branches before what they branch off from."""
    limbs: dict[int, Limb] = {}
    for tip, parent, members in tips_beyond(placed.depth, placed.layout.f, floor):
        z = placed.layout.about(tip, placed.log_unit)
        outside = np.ones(len(z), dtype=bool)
        outside[members] = False
        radius = _CLEAR * float(np.abs(z[outside]).min())
        disc = np.flatnonzero(np.abs(z) < radius)
        if len(disc) >= _LEAST_DISC:
            limbs[tip] = Limb(tip, disc, z, radius, parent)
    for limb in limbs.values():
        if limb.parent in limbs:
            around = limbs[limb.parent]
            inside = np.flatnonzero(around.disc == limb.tip)
            at = int(around.log_distance[inside[0]]) if len(inside) else 0
            around.branches.append((limb, min(at, int(around.log_distance.max()))))
    return list(limbs.values())


def tips_beyond(depth: FloatArray, f: IntArray, floor: float) -> list[tuple[int, int, IntArray]]:
    """Merge tree of the deep vertices: (tip, the deeper tip that its limb meets or -1, the limb), branches first.

    The elder rule: where two limbs meet, the one of the less deep tip ends.
    """
    n = len(depth)
    edges = np.ones(3 * len(f)), (f.ravel(), np.roll(f, -1, 1).ravel())
    graph = sp.csr_matrix(edges, shape=(n, n))
    graph = (graph + graph.T).tocsr()
    start, neighbours = graph.indptr, graph.indices
    part = np.full(n, -1)
    tip: dict[int, int] = {}
    members: dict[int, list[int]] = {}
    found: list[tuple[int, int, IntArray]] = []
    deep = np.flatnonzero(depth > _ONSET)
    for v in deep[np.argsort(-depth[deep], kind="stable")].tolist():
        here = v
        part[v], tip[v], members[v] = v, v, [v]
        for other in {int(part[u]) for u in neighbours[start[v]:start[v + 1]] if part[u] >= 0} - {v}:
            elder, younger = (here, other) if depth[tip[here]] >= depth[tip[other]] else (other, here)
            end = tip[younger]
            if depth[end] > floor and depth[end] - depth[v] >= _PERSISTENCE:
                found.append((end, tip[elder], np.array(members[younger])))
            keep, gone = (elder, younger) if len(members[elder]) >= len(members[younger]) else (younger, elder)
            tip[keep] = tip[elder]
            part[members[gone]] = keep
            members[keep] += members.pop(gone)
            here = keep
    return found + [(tip[k], -1, np.array(rows)) for k, rows in members.items() if depth[tip[k]] > floor]


def onto_sphere(mesh: Mesh, z: LongComplex, area: FloatArray) -> FloatArray:
    """Unit rows, turned to the package's gauge before they are rounded to float64."""
    x = to_ball(z)
    x = x @ best_rotation(x.astype(np.float64), orientation_target(mesh, area), area).astype(np.longdouble)
    return (x / np.sqrt((x * x).sum(axis=1))[:, None]).astype(np.float64)


def to_ball(z: LongComplex) -> LongFloat:
    """Inverse stereographic projection, 0 to (0, 0, 1), without overflow near infinity."""
    far = np.abs(z) > 1
    u = np.where(far, 1 / np.where(far, z, 1).conj(), z)
    q = u.real**2 + u.imag**2
    height = np.where(far, q - 1, 1 - q)
    return np.column_stack((2 * u.real, 2 * u.imag, height)) / (1 + q)[:, None]
