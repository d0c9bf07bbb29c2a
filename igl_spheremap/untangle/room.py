"""Making room in float64 for what is laid out beyond it: limbs are shortened about their tips.

A limb of length l and circumference c shrinks like exp(-2 pi l / c); on a sphere in float64 edges end at exp(-35).
Where limbs go deeper, log r about each tip is shortened by the profile of least angle differences, branches first.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from ..mesh.arrays import FloatArray, IntArray
from .placed import LongComplex, Placed
from .profile import Limb, choose_kappas

#: Limbs begin where edges are shorter than exp(-this); a branch is a limb of its own if its tip is so much deeper.
_ONSET = 4.0
#: Limbs end this many nepers above the resolution of numbers about 1: tried one after the other.
_ABOVE = (1.0, 3.0)


def floors(dtype: type[np.floating]) -> list[float]:
    """Depths in nepers below which no edge is left, the deepest first."""
    return [float(-np.log(np.finfo(dtype).eps) - above) for above in _ABOVE]


class Room(NamedTuple):
    """Positions that float64 resolves, and what they cost."""

    #: In the plane, relative to the anchors of the placement.
    z: LongComplex
    #: The largest ratio by which a limb's depth was divided.
    stretch: float
    #: What it is predicted to add to the angle differences, in degrees, summed over the faces. Negative where shortened
    #: limbs suit the mesh: a ring of few vertices can't shrink from one to the next as a smooth map does.
    cost: float


def make_room(placed: Placed, source: FloatArray, floor: float) -> Room:
    """Shorten limbs until no edge on the sphere is below exp(-floor)."""
    limbs = _limbs(placed, floor)
    if not limbs:
        return Room(placed.z.astype(np.clongdouble), 1.0, 0.0)
    cost = choose_kappas(limbs, placed.f, source, placed.depth, floor)
    branches = {id(branch) for limb in limbs for branch, _ in limb.branches}
    z, anchor = placed.z.astype(np.clongdouble), np.broadcast_to(placed.anchor, placed.z.shape)
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
            z[where] = placed.z[limb.tip] + (anchor[limb.tip] - anchor[where]) + w[where]
    return Room(z, float(max(len(limb.kappa) / limb.kappa.sum() for limb in limbs)), cost)


def _limbs(placed: Placed, floor: float) -> list[Limb]:
    """Discs about the tips beyond the floor, branches before what they branch off from."""
    limbs: dict[int, Limb] = {}
    for tip, parent, members in tips_beyond(placed.depth, placed.f, floor):
        z = placed.about(tip)
        outside = np.ones(len(z), dtype=bool)
        outside[members] = False
        radius = float(np.abs(z[outside]).min()) if outside.any() else 0.0
        disc = np.flatnonzero(np.abs(z) < radius)
        if len(disc) > 1:
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

    The elder rule of persistent homology: where two limbs meet, the one of the less deep tip ends.
    """
    if depth.max() <= floor:
        return []
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
            if depth[end] > floor and depth[end] - depth[v] >= _ONSET:
                found.append((end, tip[elder], np.array(members[younger])))
            keep, gone = (elder, younger) if len(members[elder]) >= len(members[younger]) else (younger, elder)
            tip[keep] = tip[elder]
            part[members[gone]] = keep
            members[keep] += members.pop(gone)
            here = keep
    return found + [(tip[k], -1, np.array(rows)) for k, rows in members.items() if depth[tip[k]] > floor]
