"""Limbs too deep for float64 are shortened with the least change of angles.

The image of a limb of length l and circumference c shrinks like exp(-2 pi l / c), and edges on a sphere in float64
can't be shorter than exp(-35). Within a disc about the tip of such a limb the distance r from the tip becomes s:

    d log s = kappa(log r) d log r,    .05 <= kappa <= 1, constant on bins of one neper or more.

A dynamic programme over the bins, and over the tree of limbs and their branches, finds the kappas that keep every
vertex above a floor at the least sum of angle differences.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from ..mesh.arrays import TINY, ComplexArray, FloatArray, IntArray
from ..sphere.log_plane import Anchored, log_sum, plane_angles
from .layout import Placed

#: In nepers. A limb begins where edges on the sphere are shorter than exp(-4), as all are on a compact body of 80,000
#: faces. A branch counts as a limb if its tip is deeper than its beginning by the same number of nepers.
_ONSET = 4.0
#: Nepers between the floor of limbs and the resolution of numbers about 1: the edges at the tips keep one to two bits.
_MARGIN = 1.0
#: Step of kappa, from 1 down to this: a finer table costs time in proportion and changes no angle visibly.
_STEP = 0.05
_KAPPAS = 1 - _STEP * np.arange(round(1 / _STEP))
#: Cost, in degrees, of a vertex for each neper below the floor. Its two faces cost at most 240: the angles of a folded
#: face sum to -pi in place of pi, so its mean difference is 120.
_BELOW = 300.0
#: Extra vertices per bin, of equilateral faces, so that shortening an empty bin is not free.
_SPARE = 0.3
#: Width of a bin at least, as a share of the deepest limb: the table grows as the square of the number of bins.
_NARROWEST = 0.005


class Branch(NamedTuple):
    """A branch of the merge tree of deep vertices."""

    #: Its deepest vertex.
    tip: int
    #: The tip of the deeper branch that it meets; -1 if there is none.
    meets: int
    vertices: IntArray


@dataclass(frozen=True, eq=False)
class Limb:
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
    branches : list of Limb
        Limbs whose branches of the merge tree meet this one.
    """

    tip: int
    disc: IntArray
    log: ComplexArray
    log_radius: float
    width: float
    branches: list[Limb]

    @cached_property
    def apart(self) -> IntArray:
        """The disc's vertices but those at the tip."""
        return self.disc[np.isfinite(self.log.real[self.disc])]

    @cached_property
    def inwards(self) -> FloatArray:
        """Nepers from the rim to each vertex of the disc; to the tip, the nepers to the vertex nearest to it."""
        return np.minimum(
            self.log_radius - self.log.real[self.disc],
            self.log_radius - self.log.real[self.apart].min(),
        )

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
        return self.bins_at(
            self.log_radius - self.log.real[[branch.tip for branch in self.branches]]
        )


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
    branches : list of Table
        Those of the branches.
    """

    least: FloatArray
    choice: IntArray
    useful: IntArray
    branches: list[Table]

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
        depth_b the depth of the deepest. A gain beyond u_b is useless.
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
            later = value + _BELOW * costs.vertices[b] * missing
            later = np.concatenate((later, np.repeat(later[:, -1:], len(thinner), axis=1)), axis=1)
            total = np.stack(
                [costs.angles[b, i] + row[i : i + steps] for i, row in enumerate(later)]
            )
            choice[b] = total.argmin(axis=0)
            value = total.min(axis=0)
        return cls(value, choice, costs.useful, list(branches))

    def chosen(self, gained: int) -> tuple[FloatArray, IntArray]:
        """Trace back the optimum from the steps gained at the rim: each bin's kappa, and the useful steps up to it."""
        kappas, gains, last = [], [], self.choice.shape[1] - 1
        for choice, useful in zip(self.choice, self.useful, strict=True):
            step = int(choice[min(gained, last)])
            gained += step
            kappas.append(_KAPPAS[step])
            gains.append(min(gained, int(useful)))
        return np.array(kappas), np.array(gains)


def floor_of(dtype: type[np.floating]) -> float:
    """The floor for numbers of a type: the depth in nepers that no edge is to exceed."""
    return float(-np.log(np.finfo(dtype).eps) - _MARGIN)


def normal_range(floor: float) -> float:
    """Nepers from an end of an axis within which float64 holds edges at a floor as normal numbers."""
    return float(-np.log(TINY)) - floor


def shorten_limbs(placed: Placed, source: FloatArray, floor: float) -> tuple[Anchored, float]:
    """Shorten limbs until no edge on the sphere is below exp(-floor); `source` are the angles to keep.

    Returns the positions, and the largest ratio by which a limb's depth was divided.
    """
    points = placed.points
    z, stretch = points.z.astype(np.clongdouble), 1.0
    for limb in _limbs(tips_beyond(placed.depth, placed.f, floor, placed.finer), placed):
        rows, log, divided = _drawn(limb, _table(limb, placed, source, floor), 0)
        z[rows] = points.beside(limb.tip, np.exp(log), rows)
        stretch = max(stretch, divided)
    return points._replace(z=z), stretch


def tips_beyond(
    depth: FloatArray, f: IntArray, floor: float, finer: FloatArray | float = 0.0
) -> list[Branch]:
    """Merge tree of the deep vertices, each branch before the one that it meets.

    The elder rule of persistent homology: where two limbs meet, the one of the less deep tip ends. Limbs begin where
    edges are short, even if coordinates are `finer` there: a limb is shortened along its whole length.
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
    found: list[Branch] = []
    deep = np.flatnonzero(inwards > _ONSET)
    for v in deep[np.argsort(-inwards[deep], kind="stable")].tolist():
        here = v
        part[v], tip[v], members[v] = v, v, [v]
        for other in {part[u] for u in neighbours[start[v] : start[v + 1]] if part[u] >= 0} - {v}:
            elder, younger = here, other
            if inwards[tip[here]] < inwards[tip[other]]:
                elder, younger = other, here
            end = tip[younger]
            if depth[end] > floor and inwards[end] - inwards[v] >= _ONSET:
                found.append(Branch(end, tip[elder], np.array(members[younger])))
            keep, gone = elder, younger
            if len(members[elder]) < len(members[younger]):
                keep, gone = younger, elder
            tip[keep] = tip[elder]
            for u in members[gone]:
                part[u] = keep
            members[keep] += members.pop(gone)
            here = keep
    return found + [
        Branch(tip[k], -1, np.array(rows)) for k, rows in members.items() if depth[tip[k]] > floor
    ]


def _limbs(found: list[Branch], placed: Placed) -> list[Limb]:
    """Make a limb of the disc about each tip, and list the limbs that are no branch of another."""
    inwards = placed.depth + placed.finer
    width = max(1.0, _NARROWEST * float(inwards[np.isfinite(inwards)].max()))
    apart: list[tuple[int, Limb]] = []  # the tip of the branch that each meets, and the limb
    for tip, meets, vertices in found:
        log = placed.about(tip)
        radius = float(np.delete(log.real, vertices).min(initial=np.inf))
        disc = np.flatnonzero(log.real < radius)
        if np.isfinite(log.real[disc]).any() and len(disc) < len(log):
            branches = [limb for met, limb in apart if met == tip]
            apart = [each for each in apart if each[0] != tip]
            apart.append((meets, Limb(tip, disc, log, radius, width, branches)))
    return [limb for _, limb in apart]


def _table(limb: Limb, placed: Placed, source: FloatArray, floor: float) -> Table:
    """Solve the tables of the branches of a limb, then its own."""
    branches = [_table(branch, placed, source, floor) for branch in limb.branches]
    return Table.of(_costs(limb, placed, source, floor), branches, limb.branches_at)


def _costs(limb: Limb, placed: Placed, source: FloatArray, floor: float) -> Costs:
    """Measure the cost of shortening in each bin.

    Every gain is of use, except at an end of an axis: float64 holds normal numbers of any size there, so a gain is of
    use only up to normal numbers.
    """
    at, bins = limb.bins_at(limb.inwards), limb.bins
    own = np.ones(len(limb.disc), dtype=bool)
    for branch in limb.branches:
        own &= ~np.isin(limb.disc, branch.disc)
    deepest, finer = np.zeros((2, bins))
    np.maximum.at(deepest, at[own], placed.depth[limb.disc[own]])
    inner, finer_at = (
        np.isin(limb.disc, limb.apart),
        np.broadcast_to(placed.finer, placed.depth.shape),
    )
    np.maximum.at(finer, at[inner], finer_at[limb.apart])
    # two faces a vertex
    angles = _bin_costs(limb, placed.f, source) / 2 + _SPARE * _equilateral_costs()
    # Beyond the gain that lifts the deepest vertex to the floor costs are constant: the table ends one bin later.
    step = _STEP * limb.width
    steps = int((placed.depth.max() - np.log(_KAPPAS[-1]) - floor) / step) + len(_KAPPAS)
    useful = np.full(bins, steps)
    if np.isinf(finer_at[limb.tip]):
        useful = np.clip((finer - normal_range(floor)) / step, 0, steps).astype(np.int64)
    vertices = np.asarray(np.bincount(at, minlength=bins) + _SPARE, dtype=np.float64)
    return Costs(angles, vertices, deepest, useful, floor, step, steps)


def _drawn(limb: Limb, table: Table, gained: int) -> tuple[IntArray, ComplexArray, float]:
    """Vertices of a limb and its branches, logarithms of their new positions relative to its tip, and the stretch."""
    kappas, gains = table.chosen(gained)
    log, rows, stretch = limb.log.copy(), [limb.disc], float(len(kappas) / kappas.sum())
    for branch, own, b in zip(
        limb.branches, table.branches, limb.branches_at.tolist(), strict=True
    ):
        inside, about_branch, divided = _drawn(branch, own, int(gains[b]))
        log[inside] = log_sum(limb.log[branch.tip], about_branch)
        rows.append(inside)
        stretch = max(stretch, divided)
    distance = limb.log_radius - log.real[limb.apart]
    log[limb.apart] += distance - _shortened(distance, kappas, limb.width)
    where = np.unique(np.concatenate(rows))
    return where, log[where], float(stretch)


def _shortened(distance: FloatArray, kappas: FloatArray, width: float) -> FloatArray:
    """Nepers from the rim after shortening: piecewise linear, beyond the last bin with its slope."""
    knots = width * np.arange(len(kappas) + 1)
    values = width * np.append(0, np.cumsum(kappas))
    inside = np.where(distance >= 0, np.interp(distance, knots, values), distance)
    return np.where(distance > knots[-1], values[-1] + (distance - knots[-1]) * kappas[-1], inside)


def _bin_costs(limb: Limb, f: IntArray, source: FloatArray) -> FloatArray:
    """Increase, by each kappa, of the mean angle differences of each bin's own faces, summed, in degrees."""
    inside = np.zeros(len(limb.log), dtype=bool)
    inside[limb.apart] = True
    faces = np.flatnonzero(inside[f].all(axis=1))
    log, unit = limb.log.real[f[faces]], np.exp(1j * limb.log.imag[f[faces]])
    middle = log.mean(axis=1, keepdims=True)
    at, cost = limb.bins_at(limb.log_radius - middle[:, 0]), np.empty((limb.bins, len(_KAPPAS)))
    for i, kappa in enumerate(_KAPPAS):
        angles = plane_angles(np.exp(kappa * (log - middle)) * unit)
        cost[:, i] = np.bincount(
            at, np.degrees(np.abs(angles - source[faces]).mean(axis=1)), limb.bins
        )
    return cost - cost[:, :1]


@cache
def _equilateral_costs() -> FloatArray:
    """Mean angle difference, in degrees, of equilateral triangles of all directions squashed by each kappa."""
    turn = np.exp(
        1j * (np.linspace(0, 2 * np.pi, 60, endpoint=False)[:, None] + np.arange(3) * 2 * np.pi / 3)
    )
    return np.array(
        [
            np.degrees(
                np.abs(np.abs(plane_angles(k * turn.real + 1j * turn.imag)) - np.pi / 3).mean()
            )
            for k in _KAPPAS
        ]
    )
