"""Limbs too deep for float64 are shortened with the least change of angles.

The image of a limb of length l and circumference c shrinks like exp(-2 pi l / c), and edges on a sphere in float64
can't be shorter than exp(-35). Within a disc about the tip of such a limb the distance r from the tip becomes s:

    d log s = kappa(log r) d log r,    .05 <= kappa <= 1, constant on bins of one neper or more.

A dynamic programme over the bins, and over the tree of limbs and branches, finds the kappas that keep every vertex
above a floor at the least sum of angle differences.

`shorten_limbs` finds the tips (`tips_beyond`), makes a `DeepLimb` of the disc about each, measures its `Costs`, solves
its `Table`, and draws the vertices towards the rim by its kappas.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from ..mesh.arrays import TINY, BoolArray, ComplexArray, FloatArray, IntArray
from ..sphere.log_plane import Anchored, log_sum, plane_angles
from .layout import Placed

#: Kappas go down from 1 by this step: a finer table costs time in proportion and changes no angle visibly.
_STEP = 0.05
_KAPPAS = 1 - _STEP * np.arange(round(1 / _STEP))


def floor_of(dtype: type[np.floating]) -> float:
    """The floor for numbers of a type: the depth in nepers that no edge is to exceed.

    It is a neper above the resolution of numbers about 1: the edges at the tips keep one to two bits.
    """
    return float(-np.log(np.finfo(dtype).eps) - 1.0)


def normal_range(floor: float) -> float:
    """Nepers from an end of an axis within which float64 holds edges at a floor as normal numbers."""
    return float(-np.log(TINY)) - floor


def shorten_limbs(placed: Placed, source: FloatArray, floor: float) -> tuple[Anchored, float]:
    """Shorten limbs until no edge on the sphere is below exp(-floor); `source` are the angles to keep.

    Returns the positions, and the largest ratio by which a limb's depth was divided.
    """
    points = placed.points
    z, stretch = points.z.astype(np.clongdouble), 1.0
    for limb in _limbs(placed, source, floor):
        rows, log, divided = limb.drawn(0)
        z[rows] = points.beside(limb.tip, np.exp(log), rows)
        stretch = max(stretch, divided)
    return points._replace(z=z), stretch


class Tip(NamedTuple):
    """The tip of a limb: a vertex that is deeper than its neighbours."""

    vertex: int
    #: The tip of the deeper limb that the limb meets; -1 if there is none.
    meets: int
    #: The vertices of the limb, up to its meeting with that one.
    members: IntArray


def tips_beyond(placed: Placed, floor: float, onset: float = 4.0) -> list[Tip]:
    """Tips deeper than a floor, each before the one that it meets: the merge tree of the deep vertices.

    The elder rule of persistent homology: where two limbs meet, the one of the less deep tip ends. Limbs begin where
    edges are shorter than exp(-onset), as all are on a compact body of 80,000 faces, even if coordinates are finer
    there: a limb that has to be shortened is shortened along its whole length. A limb whose tip is deeper by `onset`
    than its meeting with another is one of its own.
    """
    if placed.depth.max() <= floor:
        return []
    inwards, n = placed.inwards, len(placed.depth)
    start, neighbours = _neighbours(placed.f, n)
    part = [-1] * n  # of each vertex, the key of the limb that has it so far
    tip: dict[int, int] = {}
    members: dict[int, list[int]] = {}
    found: list[Tip] = []
    deep = np.flatnonzero(inwards > onset)
    for v in deep[np.argsort(-inwards[deep], kind="stable")].tolist():
        here = v
        part[v], tip[v], members[v] = v, v, [v]
        for other in {part[u] for u in neighbours[start[v] : start[v + 1]] if part[u] >= 0} - {v}:
            elder, younger = here, other
            if inwards[tip[here]] < inwards[tip[other]]:
                elder, younger = other, here
            end = tip[younger]
            if placed.depth[end] > floor and inwards[end] - inwards[v] >= onset:
                found.append(Tip(end, tip[elder], np.array(members[younger])))
            keep, gone = elder, younger
            if len(members[elder]) < len(members[younger]):  # the longer list stays: less to copy
                keep, gone = younger, elder
            tip[keep] = tip[elder]
            for u in members[gone]:
                part[u] = keep
            members[keep] += members.pop(gone)
            here = keep
    roots = [Tip(tip[k], -1, np.array(rows)) for k, rows in members.items()]
    return found + [root for root in roots if placed.depth[root.vertex] > floor]


def _neighbours(f: IntArray, n: int) -> tuple[list[int], list[int]]:
    """First place of each vertex's neighbours in a list, and that list."""
    edges = np.ones(3 * len(f)), (f.ravel(), np.roll(f, -1, 1).ravel())
    graph = sp.csr_matrix(edges, shape=(n, n))
    graph = (graph + graph.T).tocsr()
    return graph.indptr.tolist(), graph.indices.tolist()


def _limbs(placed: Placed, source: FloatArray, floor: float) -> list[DeepLimb]:
    """The limbs that are to be shortened and are no branches of others.

    Bins have at least a width of half a percent of the deepest limb: the table grows as the square of their number.
    """
    inwards = placed.inwards
    width = max(1.0, 0.005 * float(inwards[np.isfinite(inwards)].max()))
    apart: list[tuple[int, DeepLimb]] = []  # the tip that each limb meets, and the limb
    for tip, meets, members in tips_beyond(placed, floor):
        log = placed.about(tip)
        radius = float(np.delete(log.real, members).min(initial=np.inf))
        disc = np.flatnonzero(log.real < radius)
        if np.isfinite(log.real[disc]).any() and len(disc) < len(log):
            branches = [limb for met, limb in apart if met == tip]
            apart = [each for each in apart if each[0] != tip]
            limb = DeepLimb(placed, source, floor, tip, disc, log, radius, width, branches)
            apart.append((meets, limb))
    return [limb for _, limb in apart]


@dataclass(frozen=True, eq=False)
class DeepLimb:
    """A disc of vertices about a tip that is to be shortened, in bins by the distance from its rim.

    Attributes
    ----------
    placed, source, floor
        As of `shorten_limbs`.
    tip, disc
        The tip, and the vertices of the disc with it.
    log : (n,) complex array
        Logarithms of the positions of all vertices relative to the tip, in the plane's unit.
    log_radius : float
        Of the disc, in that unit.
    width : float
        Of the bins, in nepers.
    branches : list of DeepLimb
        Limbs that meet this one.
    """

    placed: Placed
    source: FloatArray
    floor: float
    tip: int
    disc: IntArray
    log: ComplexArray
    log_radius: float
    width: float
    branches: list[DeepLimb]

    @cached_property
    def is_apart(self) -> BoolArray:
        """Whether each vertex of the disc is off the tip."""
        return np.isfinite(self.log.real[self.disc])

    @cached_property
    def apart(self) -> IntArray:
        """The disc's vertices but those at the tip."""
        return self.disc[self.is_apart]

    @cached_property
    def inwards(self) -> FloatArray:
        """Nepers from the rim to each vertex of the disc; to the tip, the nepers to the vertex nearest to it."""
        distance = self.log_radius - self.log.real[self.disc]
        return np.minimum(distance, distance[self.is_apart].max())

    @cached_property
    def bins(self) -> int:
        """Number of bins; the last one holds the tip."""
        return int(self.inwards.max() / self.width) + 1

    def bins_at(self, distance: FloatArray) -> IntArray:
        """Bins at distances from the rim, in nepers."""
        return np.clip((distance / self.width).astype(np.int64), 0, self.bins - 1)

    @cached_property
    def branches_at(self) -> IntArray:
        """Bins that hold the tips of the branches."""
        tips = [branch.tip for branch in self.branches]
        return self.bins_at(self.log_radius - self.log.real[tips])

    @cached_property
    def table(self) -> Table:
        """The least costs of the limb, after those of its branches."""
        branches = [branch.table for branch in self.branches]
        return Table.of(self._costs(), branches, self.branches_at)

    def drawn(self, gained: int) -> tuple[IntArray, ComplexArray, float]:
        """Vertices of the limb and its branches, logarithms of their new positions relative to the tip, the stretch.

        `gained` are the steps by which the limb is shortened outside its rim.
        """
        kappas, gains = self.table.chosen(gained)
        log, rows, stretch = self.log.copy(), [self.disc], float(len(kappas) / kappas.sum())
        for branch, b in zip(self.branches, self.branches_at, strict=True):
            inside, about_branch, divided = branch.drawn(int(gains[b]))
            log[inside] = log_sum(self.log[branch.tip], about_branch)
            rows.append(inside)
            stretch = max(stretch, divided)
        distance = self.log_radius - log.real[self.apart]
        log[self.apart] += distance - _shortened(distance, kappas, self.width)
        where = np.unique(np.concatenate(rows))
        return where, log[where], stretch

    def _costs(self, spare: float = 0.3) -> Costs:
        """Measure the cost of shortening in each bin.

        Every gain is of use, except at an end of an axis: float64 holds normal numbers of any size there, so that only
        a gain that lifts a vertex to normal numbers is of use. Each bin has `spare` vertices more, of equilateral
        faces, so that shortening an empty bin is not free.
        """
        placed, at, bins = self.placed, self.bins_at(self.inwards), self.bins
        own = np.ones(len(self.disc), dtype=bool)
        for branch in self.branches:
            own &= ~np.isin(self.disc, branch.disc)
        finer_at = np.broadcast_to(placed.finer, placed.depth.shape)
        deepest, finer = np.zeros((2, bins))
        np.maximum.at(deepest, at[own], placed.depth[self.disc[own]])
        np.maximum.at(finer, at[self.is_apart], finer_at[self.apart])
        # Beyond the gain that lifts the deepest vertex to the floor costs are constant: the table ends one bin later.
        step = _STEP * self.width
        steps = int((placed.depth.max() - np.log(_KAPPAS[-1]) - self.floor) / step) + len(_KAPPAS)
        useful = np.full(bins, steps)
        if np.isinf(finer_at[self.tip]):
            gain = (finer - normal_range(self.floor)) / step
            useful = np.clip(gain, 0, steps).astype(np.int64)
        return Costs(
            self._angle_costs() / 2 + spare * _equilateral_costs(),  # two faces a vertex
            np.asarray(np.bincount(at, minlength=bins) + spare, dtype=np.float64),
            deepest,
            useful,
            self.floor,
            step,
            steps,
        )

    def _angle_costs(self) -> FloatArray:
        """Increase, by each kappa, of the mean angle differences of each bin's own faces, summed, in degrees."""
        inside = np.zeros(len(self.log), dtype=bool)
        inside[self.apart] = True
        faces = np.flatnonzero(inside[self.placed.f].all(axis=1))
        corners, source = self.log[self.placed.f[faces]], self.source[faces]
        log, unit = corners.real, np.exp(1j * corners.imag)
        middle = log.mean(axis=1, keepdims=True)
        at = self.bins_at(self.log_radius - middle[:, 0])
        cost = np.empty((self.bins, len(_KAPPAS)))
        for i, kappa in enumerate(_KAPPAS):
            angles = plane_angles(np.exp(kappa * (log - middle)) * unit)
            size = np.degrees(np.abs(angles - source).mean(axis=1))
            cost[:, i] = np.bincount(at, size, self.bins)
        return cost - cost[:, :1]


def _shortened(distance: FloatArray, kappas: FloatArray, width: float) -> FloatArray:
    """Nepers from the rim after shortening: piecewise linear, beyond the last bin with its slope."""
    knots = width * np.arange(len(kappas) + 1)
    values = width * np.append(0, np.cumsum(kappas))
    inside = np.where(distance >= 0, np.interp(distance, knots, values), distance)
    return np.where(distance > knots[-1], values[-1] + (distance - knots[-1]) * kappas[-1], inside)


@cache
def _equilateral_costs() -> FloatArray:
    """Mean angle difference, in degrees, of equilateral triangles of all directions squashed by each kappa."""
    directions = np.linspace(0, 2 * np.pi, 60, endpoint=False)[:, None]
    z, costs = np.exp(1j * (directions + np.arange(3) * 2 * np.pi / 3)), []
    for kappa in _KAPPAS:
        angles = np.abs(plane_angles(kappa * z.real + 1j * z.imag))
        costs.append(np.degrees(np.abs(angles - np.pi / 3).mean()))
    return np.array(costs)


class Costs(NamedTuple):
    """Costs of shortening in each bin of a limb, in degrees summed over faces."""

    #: Cost of each kappa in angle differences, (bins, kappas).
    angles: FloatArray
    #: Number of vertices in each bin.
    vertices: FloatArray
    #: Depth of each bin's deepest vertex, in nepers.
    deepest: FloatArray
    #: Steps per bin after which further shortening no longer helps its vertices.
    useful: IntArray
    floor: float
    #: Nepers that a bin gains as kappa falls by `_STEP`.
    step: float
    #: Steps beyond which costs are constant.
    steps: int


@dataclass(frozen=True, eq=False)
class Table:
    """The least cost of a limb, and its kappas, for each number of steps gained outside its rim.

    Attributes
    ----------
    least : (steps,) float64 array
        The least cost of the limb with its branches.
    choice : (bins, steps) int64 array
        Index of the best kappa in each bin, by the steps that were gained outside the bin.
    useful : (bins,) int64 array
        As of `Costs`.
    """

    least: FloatArray
    choice: IntArray
    useful: IntArray

    @classmethod
    def of(
        cls,
        costs: Costs,
        branches: Sequence[Table] = (),
        branches_at: Sequence[int] | IntArray = (),
    ) -> Table:
        """Solve for the least cost V_0 of a limb, from the tip outwards, for every gain g in nepers outside its rim.

            V_b(g) = min over kappa of  C_b(kappa) + W_b(min(h, u_b)) + V_{b+1}(h),    h = g + w (1 - kappa),
            W_b(h) = 300 n_b max(0, depth_b - log kappa - h - floor) + sum of V_0(h) of the branches at bin b.

        w is the width of bins, C_b the cost of a kappa to the faces of bin b in angles, n_b the number of its vertices,
        depth_b the depth of the deepest. A gain is of use up to u_b. A vertex costs 300 degrees for each neper below
        the floor. Its two faces cost at most 240: the angles of a folded face sum to -pi in place of pi, so its mean
        difference is 120.
        """
        bins, steps = len(costs.angles), costs.steps
        thinner, value = -np.log(_KAPPAS)[:, None], np.zeros(steps)
        choice = np.zeros((bins, steps), dtype=np.int64)
        for b in range(bins - 1, -1, -1):
            gained = np.minimum(np.arange(steps), costs.useful[b])
            for branch, at in zip(branches, branches_at, strict=True):
                if at == b:
                    value = value + branch.least[np.minimum(gained, len(branch.least) - 1)]
            missing = np.maximum(0, costs.deepest[b] + thinner - costs.step * gained - costs.floor)
            later = value + 300.0 * costs.vertices[b] * missing
            later = np.concatenate((later, np.repeat(later[:, -1:], len(thinner), axis=1)), axis=1)
            total = np.stack(
                [costs.angles[b, i] + row[i : i + steps] for i, row in enumerate(later)]
            )
            choice[b] = total.argmin(axis=0)
            value = total.min(axis=0)
        return cls(value, choice, costs.useful)

    def chosen(self, gained: int) -> tuple[FloatArray, IntArray]:
        """Trace back the optimum from the steps gained at the rim: each bin's kappa, and the useful steps up to it."""
        kappas, gains, last = [], [], self.choice.shape[1] - 1
        for choice, useful in zip(self.choice, self.useful, strict=True):
            step = int(choice[min(gained, last)])
            gained += step
            kappas.append(_KAPPAS[step])
            gains.append(min(gained, int(useful)))
        return np.array(kappas), np.array(gains)
