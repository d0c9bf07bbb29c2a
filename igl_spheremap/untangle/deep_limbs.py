"""Limbs that float64 can't hold are shortened where that changes angles least.

A limb of length l and circumference c shrinks like exp(-2 pi l / c), and edges on a sphere in float64 end at exp(-35).
Within a disc about the tip of such a limb the distance r from the tip becomes s:

    d log s = kappa(log r) d log r,    .05 <= kappa <= 1, constant on bins of one neper or more.

A dynamic programme over the bins, and over the tree of limbs and their branches, finds the kappas that keep every
vertex above a floor at the least sum of angle differences.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from ..mesh.arrays import ComplexArray, FloatArray, IntArray
from ..sphere.stereographic import LongComplex, log_sum, plane_angles
from .layout import Placed

#: A limb begins where edges are shorter than exp(-4), those of a compact body of 80,000 faces. A branch is a limb of
#: its own if its tip is as much deeper than where it begins. With 2 and 8 springs and octopuses end 1.6 percent lower
#: (`python -m benchmarks versions . sample:spring sample:spring:turns=2 sample:octopus sample:octopus:arm_length=6
#: --set untangle.deep_limbs._ONSET=8`).
_ONSET = 4.0
#: Nepers between the floor of limbs and the resolution of numbers about 1. With the first the edges at the tips keep
#: one to two bits; the second, which leaves four, is tried where rounding folds so much that the first map is lost.
_MARGINS = (1.0, 3.0)
#: Step of kappa, from 1 down to this: a finer table costs time in proportion and changes no angle visibly.
_STEP = 0.05
_KAPPAS = 1 - _STEP * np.arange(round(1 / _STEP))
#: Cost, in degrees, of a vertex for each neper below the floor. Its two faces can't cost more than 240: a folded face
#: has angles of sum -pi in place of pi, so its mean difference is 120.
_BELOW = 300.0
#: Equilateral triangles are counted as this many vertices of each bin: else to squash an empty bin would cost nothing.
#: With .1 and 1 spring, comb, sword, dilo and octopus_low end within .6 percent (`python -m benchmarks versions .
#: MESH ... --set untangle.deep_limbs._SPARE=.1`).
_SPARE = 0.3
#: Width of a bin at least, as a share of the deepest limb: the table grows as the square of the number of bins.
_NARROWEST = 0.005


class Shortened(NamedTuple):
    """Positions that float64 resolves."""

    #: In the plane, relative to the anchors of the placement.
    z: LongComplex
    #: The largest ratio by which a limb's depth was divided.
    stretch: float


@dataclass(eq=False)
class DeepLimb:
    """A disc of vertices about a tip that is to be shortened, and the limbs that branch off within it.

    Attributes
    ----------
    tip, disc
        The tip, and the vertices of the disc with it.
    log : (n,) complex array
        Logarithms of the positions of all vertices relative to the tip, in the plane's unit.
    log_radius : float
        Of the disc, in that unit.
    width : float
        Of the bins, in nepers.
    branches : list of (DeepLimb, int)
        Limbs inside the disc, with the bin of their tips.
    is_branch : bool
        Whether it lies in the disc of another limb itself.
    kappa : (bins,) float64 array
        The result, from the rim inwards.
    cost_to_go : (steps,) float64 array
        Least cost of the limb with its branches, by the steps that were gained outside its rim.
    choice : (bins, steps) int64 array
        Index of the best kappa in each bin, by the steps that were gained outside the bin.
    useful : (bins,) int64 array
        How many of the steps that were gained bring the vertices of a bin nearer to the floor.
    """

    tip: int
    disc: IntArray
    log: ComplexArray
    log_radius: float
    width: float
    branches: list[tuple[DeepLimb, int]] = field(default_factory=list)
    is_branch: bool = False
    kappa: FloatArray = field(init=False)
    cost_to_go: FloatArray = field(init=False)
    choice: IntArray = field(init=False)
    useful: IntArray = field(init=False)

    @property
    def log_distance(self) -> FloatArray:
        """Nepers from the rim inwards, for the disc's vertices; the tip's as its nearest neighbour's."""
        distance = self.log_radius - self.log.real[self.disc]
        return np.minimum(distance, distance[self.disc != self.tip].max())

    def bins(self, distance: FloatArray) -> IntArray:
        """Bins of given distances from the rim, in nepers; the last one is that of the tip."""
        last = int(self.log_distance.max() / self.width)
        return np.clip((distance / self.width).astype(np.int64), 0, last)

    def shortened(self, distance: FloatArray) -> FloatArray:
        """Nepers from the rim after shortening: piecewise linear, beyond the last bin with its slope."""
        knots = self.width * np.arange(len(self.kappa) + 1)
        values = self.width * np.append(0, np.cumsum(self.kappa))
        inside = np.where(distance >= 0, np.interp(distance, knots, values), distance)
        return np.where(distance > knots[-1], values[-1] + (distance - knots[-1]) * self.kappa[-1], inside)


def floors(dtype: type[np.floating]) -> list[float]:
    """Depths in nepers below which no edge is to be left in numbers of a type, the deepest first."""
    return [float(-np.log(np.finfo(dtype).eps) - margin) for margin in _MARGINS]


def normal_range(floor: float) -> float:
    """Nepers from the tips at ends of axes within which coordinates hold edges above a floor as normal numbers."""
    return float(-np.log(np.finfo(float).tiny)) - floor


def shorten_limbs(placed: Placed, source: FloatArray, floor: float) -> Shortened:
    """Shorten limbs until no edge on the sphere is below exp(-floor); `source` are the angles to keep."""
    limbs = _planned(tips_beyond(placed.depth, placed.f, floor, placed.finer), placed, source, floor)
    if not limbs:
        return Shortened(placed.z.astype(np.clongdouble), 1.0)
    for limb in limbs:
        if not limb.is_branch:
            _follow(limb, 0)
    z, anchor = placed.z.astype(np.clongdouble), np.broadcast_to(placed.anchor, placed.log.shape)
    moved: dict[int, tuple[IntArray, ComplexArray]] = {}  # by the tip of a limb: its vertices, and where it puts them
    for limb in limbs:
        log, vertices = limb.log.copy(), [limb.disc]
        for branch, _ in limb.branches:
            where, at = moved[branch.tip]
            log[where] = log_sum(limb.log[branch.tip], at)
            vertices.append(where)
        other = limb.disc[limb.disc != limb.tip]
        distance = limb.log_radius - log.real[other]
        log[other] += distance - limb.shortened(distance)
        where = np.unique(np.concatenate(vertices))
        moved[limb.tip] = where, log[where]
        if not limb.is_branch:
            z[where] = placed.z[limb.tip] + (anchor[limb.tip] - anchor[where]) + np.exp(log[where])
    return Shortened(z, float(max(len(limb.kappa) / limb.kappa.sum() for limb in limbs)))


def suits_shortening(placed: Placed, source: FloatArray, floor: float) -> bool:
    """Whether the deepest limb is predicted to lose no angles as it is shortened, or none is beyond the floor.

    So it is on a mesh that is too coarse for its depth: a ring of few vertices can't shrink from one to the next as a
    smooth map does.
    """
    found = tips_beyond(placed.depth, placed.f, floor, placed.finer)
    of_deepest = {max((tip for tip, parent, _ in found if parent < 0), key=lambda tip: placed.depth[tip], default=-1)}
    for tip, parent, _ in reversed(found):
        if parent in of_deepest:
            of_deepest.add(tip)
    limbs = _planned([limb for limb in found if limb[0] in of_deepest], placed, source, floor)
    return not limbs or bool(limbs[-1].cost_to_go[0] <= 0)


def _planned(found: list[tuple[int, int, IntArray]], placed: Placed, source: FloatArray,
             floor: float) -> list[DeepLimb]:
    """Discs about tips beyond the floor, branches before what they branch off from, with the costs of their kappas."""
    limbs: dict[int, DeepLimb] = {}
    parents: dict[int, int] = {}
    inwards = placed.depth + placed.finer
    width = max(1.0, _NARROWEST * float(inwards[np.isfinite(inwards)].max()))
    for tip, parent, members in found:
        log = placed.about(tip)
        radius = float(np.delete(log.real, members).min(initial=np.inf))
        disc = np.flatnonzero(log.real < radius)
        if 1 < len(disc) < len(log):
            limbs[tip], parents[tip] = DeepLimb(tip, disc, log, radius, width), parent
    for tip, limb in limbs.items():
        if parents[tip] in limbs:
            around = limbs[parents[tip]]
            inside = np.flatnonzero(around.disc == tip)
            distance = around.log_distance[inside] if len(inside) else np.zeros(1)
            around.branches.append((limb, int(around.bins(distance)[0])))
            limb.is_branch = True
    for limb in limbs.values():
        _plan(limb, placed, source, floor)
    return list(limbs.values())


def tips_beyond(depth: FloatArray, f: IntArray, floor: float,
                finer: FloatArray | float = 0.0) -> list[tuple[int, int, IntArray]]:
    """Merge tree of the deep vertices: (tip, the deeper tip that its limb meets or -1, the limb), branches first.

    The elder rule of persistent homology: where two limbs meet, the one of the less deep tip ends. Limbs begin where
    edges are short, though coordinates are `finer` there: what is to be shortened is shortened on its whole length.
    """
    if depth.max() <= floor:
        return []
    inwards = depth + finer
    n = len(depth)
    edges = np.ones(3 * len(f)), (f.ravel(), np.roll(f, -1, 1).ravel())
    graph = sp.csr_matrix(edges, shape=(n, n))
    graph = (graph + graph.T).tocsr()
    start, neighbours = graph.indptr.tolist(), graph.indices.tolist()
    part = [-1] * n
    tip: dict[int, int] = {}
    members: dict[int, list[int]] = {}
    found: list[tuple[int, int, IntArray]] = []
    deep = np.flatnonzero(inwards > _ONSET)
    for v in deep[np.argsort(-inwards[deep], kind="stable")].tolist():
        here = v
        part[v], tip[v], members[v] = v, v, [v]
        for other in {part[u] for u in neighbours[start[v]:start[v + 1]] if part[u] >= 0} - {v}:
            elder, younger = (here, other) if inwards[tip[here]] >= inwards[tip[other]] else (other, here)
            end = tip[younger]
            if depth[end] > floor and inwards[end] - inwards[v] >= _ONSET:
                found.append((end, tip[elder], np.array(members[younger])))
            keep, gone = (elder, younger) if len(members[elder]) >= len(members[younger]) else (younger, elder)
            tip[keep] = tip[elder]
            for u in members[gone]:
                part[u] = keep
            members[keep] += members.pop(gone)
            here = keep
    return found + [(tip[k], -1, np.array(rows)) for k, rows in members.items() if depth[tip[k]] > floor]


def _plan(limb: DeepLimb, placed: Placed, source: FloatArray, floor: float) -> None:
    """Solve for the least cost V of the limb, for every gain g in nepers outside its rim, from the tip outwards.

        V_b(g) = min over kappa of  C_b(kappa) + W_b(min(h, u_b)) + V_{b+1}(h),    h = g + w (1 - kappa),
        W_b(h) = 300 n_b max(0, depth_b - h - floor) + sum of V_0(h) of the branches whose tips are in bin b.

    w is the width of bins, C_b what a kappa costs the faces of bin b in angles, n_b the number of its vertices,
    depth_b that of the deepest. A gain is of use up to u_b: in general all of it. At an end of an axis float64 holds
    normal numbers of any size, so that only what lifts a vertex to normal numbers is of use.
    """
    at = limb.bins(limb.log_distance)
    bins = int(at.max()) + 1
    own = np.ones(len(limb.disc), dtype=bool)
    for branch, _ in limb.branches:
        own &= ~np.isin(limb.disc, branch.disc)
    deepest, finer = np.zeros((2, bins))
    np.maximum.at(deepest, at[own], placed.depth[limb.disc[own]])
    inner, finer_at = limb.disc != limb.tip, np.broadcast_to(placed.finer, placed.depth.shape)
    np.maximum.at(finer, at[inner], finer_at[limb.disc[inner]])
    count = np.bincount(at, minlength=bins) + _SPARE
    cost = _bin_costs(limb, placed.f, source, bins) / 2 + _SPARE * _equilateral_costs()  # two faces a vertex
    # Beyond the gain that lifts the deepest vertex to the floor costs are constant: the table ends one bin later.
    step = _STEP * limb.width
    thinner = -np.log(_KAPPAS)[:, None]
    steps = int((placed.depth.max() + thinner[-1, 0] - floor) / step) + cost.shape[1]
    limb.useful = np.full(bins, steps)
    if np.isinf(finer_at[limb.tip]):
        limb.useful = np.clip((finer - normal_range(floor)) / step, 0, steps).astype(np.int64)
    value = np.zeros(steps)
    limb.choice = np.zeros((bins, steps), dtype=np.int64)
    for b in range(bins - 1, -1, -1):
        gained = np.minimum(np.arange(steps), limb.useful[b])
        for branch, where in limb.branches:
            if where == b:
                value = value + branch.cost_to_go[gained]
        later = value + _BELOW * count[b] * np.maximum(0, deepest[b] + thinner - step * gained - floor)
        later = np.concatenate((later, np.repeat(later[:, -1:], len(thinner), axis=1)), axis=1)
        total = np.stack([cost[b, i] + row[i:i + steps] for i, row in enumerate(later)])
        limb.choice[b] = total.argmin(axis=0)
        value = total.min(axis=0)
    limb.cost_to_go = value


def _follow(limb: DeepLimb, gained: int) -> None:
    """Read the kappas off the choices, given the steps that are gained outside the rim."""
    limb.kappa = np.empty(len(limb.choice))
    last = limb.choice.shape[1] - 1
    for b, choice in enumerate(limb.choice):
        step = choice[min(gained, last)]
        limb.kappa[b] = _KAPPAS[step]
        gained += int(step)
        for branch, where in limb.branches:
            if where == b:
                _follow(branch, min(gained, int(limb.useful[b])))


def _bin_costs(limb: DeepLimb, f: IntArray, source: FloatArray, bins: int) -> FloatArray:
    """What each kappa adds to the mean angle differences of each bin's own faces, summed, in degrees."""
    inside = np.zeros(len(limb.log), dtype=bool)
    inside[limb.disc] = True
    inside[limb.tip] = False
    faces = np.flatnonzero(inside[f].all(axis=1))
    log, unit = limb.log.real[f[faces]], np.exp(1j * limb.log.imag[f[faces]])
    middle = log.mean(axis=1, keepdims=True)
    at = np.minimum(limb.bins(limb.log_radius - middle[:, 0]), bins - 1)
    cost = np.empty((bins, len(_KAPPAS)))
    for i, kappa in enumerate(_KAPPAS):
        angles = plane_angles(np.exp(kappa * (log - middle)) * unit)
        cost[:, i] = np.bincount(at, np.degrees(np.abs(angles - source[faces]).mean(axis=1)), bins)
    return cost - cost[:, :1]


@cache
def _equilateral_costs() -> FloatArray:
    """Mean angle difference, in degrees, of equilateral triangles of all directions squashed by each kappa."""
    turn = np.exp(1j * (np.linspace(0, 2 * np.pi, 60, endpoint=False)[:, None] + np.arange(3) * 2 * np.pi / 3))
    return np.array([np.degrees(np.abs(np.abs(plane_angles(k * turn.real + 1j * turn.imag)) - np.pi / 3).mean())
                     for k in _KAPPAS])
