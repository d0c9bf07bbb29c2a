"""How a limb that is too deep for float64 is shortened at the least cost in angles.

The radius about the limb's tip is mapped by log r -> integral of kappa d(log r), kappa between 0.05 and 1, constant on
bins of one neper. A dynamic programme over the bins, and over the tree of limbs, finds the kappas with which every
vertex stays above the floor and the sum of the angle differences is least.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..mesh.arrays import ComplexArray, FloatArray, IntArray

#: Nepers of depth that one step of kappa gains in a bin; kappa = 1, .95, ... .05.
QUANTUM = 0.05
KAPPA = 1 - QUANTUM * np.arange(20)
#: Mean angle difference, in degrees, that a folded face counts as.
_FOLDED = 120.0
#: Cost, in degrees, of one vertex that ends a neper below the floor: more than any change of its angles.
_BELOW = 300.0
#: Vertices that each bin counts beside its own, so that squashing an empty bin has a cost, too.
_SPARE = 0.3


@dataclass(eq=False)
class Limb:
    """A disc of vertices about a tip that is to be shortened, and the limbs that branch off within it.

    Attributes
    ----------
    tip, disc
        The tip, and the vertices of the disc with it.
    z : (n,) complex array
        Positions of all vertices relative to the tip, in the plane's unit.
    radius : float
        Of the disc, in that unit.
    parent : int
        Tip of the limb that this one branches off from, -1 for none.
    branches : list of (Limb, int)
        Limbs inside the disc, with the bin of their tips.
    kappa : (bins,) float64 array
        The result, from the rim inwards.
    """

    tip: int
    disc: IntArray
    z: ComplexArray
    radius: float
    parent: int = -1
    branches: list[tuple[Limb, int]] = field(default_factory=list)
    kappa: FloatArray = field(default_factory=lambda: np.ones(1))
    cost_to_go: FloatArray = field(default_factory=lambda: np.zeros(1))
    choice: IntArray = field(default_factory=lambda: np.zeros((1, 1), dtype=np.int64))

    @property
    def log_distance(self) -> FloatArray:
        """Nepers from the rim inwards, for the disc's vertices; the tip's as its nearest neighbour's."""
        distance = np.log(self.radius) - np.log(np.maximum(np.abs(self.z[self.disc]), 1e-300))
        other = self.disc != self.tip
        return np.where(other, distance, distance[other].max())

    def shortened(self, distance: FloatArray) -> FloatArray:
        """Nepers from the rim after shortening: piecewise linear, beyond the last bin with its slope."""
        knots = np.arange(len(self.kappa) + 1)
        values = np.append(0, np.cumsum(self.kappa))
        inside = np.where(distance >= 0, np.interp(distance, knots, values), distance)
        return np.where(distance > knots[-1], values[-1] + (distance - knots[-1]) * self.kappa[-1], inside)


def choose_kappas(limbs: list[Limb], f: IntArray, source: FloatArray, depth: FloatArray, floor: float) -> float:
    """Set the kappas of limbs, branches before what they branch off from.

    Returns what they are predicted to add to the angle differences, in degrees, summed over the faces.
    """
    steps = int(max(depth.max() - floor + 5, 1) / QUANTUM) + len(KAPPA)
    branches = {id(branch) for limb in limbs for branch, _ in limb.branches}
    for limb in limbs:
        _plan(limb, f, source, depth, floor, steps)
    roots = [limb for limb in limbs if id(limb) not in branches]
    for limb in roots:
        _follow(limb, 0)
    return float(sum(limb.cost_to_go[0] for limb in roots))


def _plan(limb: Limb, f: IntArray, source: FloatArray, depth: FloatArray, floor: float, steps: int) -> None:
    """Cost of the limb for every depth that is gained outside its rim, and the best choice for each bin."""
    distance = limb.log_distance
    bins = int(distance.max()) + 1
    at = np.minimum(distance.astype(np.int64), bins - 1)
    own = np.ones(len(limb.disc), dtype=bool)
    for branch, _ in limb.branches:
        own &= ~np.isin(limb.disc, branch.disc)
    deepest = np.zeros(bins)
    np.maximum.at(deepest, at[own], depth[limb.disc[own]])
    count = np.bincount(at, minlength=bins) + _SPARE
    cost = _bin_costs(limb, f, source, bins) / 2 + _SPARE * EQUILATERAL  # two faces a vertex
    gained = QUANTUM * np.arange(steps)
    value = np.zeros(steps)
    limb.choice = np.zeros((bins, steps), dtype=np.int64)
    for b in range(bins - 1, -1, -1):
        value = value + _BELOW * count[b] * np.maximum(0, deepest[b] - gained - floor)
        for branch, where in limb.branches:
            if where == b:
                value = value + branch.cost_to_go
        later = np.append(value, np.full(len(KAPPA), value[-1]))
        total = np.stack([cost[b, i] + later[i:i + steps] for i in range(len(KAPPA))])
        limb.choice[b] = total.argmin(axis=0)
        value = total.min(axis=0)
    limb.cost_to_go = value


def _follow(limb: Limb, gained: int) -> None:
    """Read the kappas off the choices, given the steps that are gained outside the rim."""
    limb.kappa = np.empty(len(limb.choice))
    last = limb.choice.shape[1] - 1
    for b, choice in enumerate(limb.choice):
        step = choice[min(gained, last)]
        limb.kappa[b] = KAPPA[step]
        gained += int(step)
        for branch, where in limb.branches:
            if where == b:
                _follow(branch, gained)


def _bin_costs(limb: Limb, f: IntArray, source: FloatArray, bins: int) -> FloatArray:
    """What each kappa adds to the mean angle differences of each bin's own faces, summed, in degrees."""
    inside = np.zeros(len(limb.z), dtype=bool)
    inside[limb.disc] = True
    inside[limb.tip] = False
    faces = np.flatnonzero(inside[f].all(axis=1))
    z = limb.z[f[faces]]
    size = np.maximum(np.abs(z), 1e-300)
    log, unit = np.log(size), z / size
    middle = log.mean(axis=1, keepdims=True)
    at = np.clip((np.log(limb.radius) - middle[:, 0]).astype(np.int64), 0, bins - 1)
    cost = np.empty((bins, len(KAPPA)))
    for i, kappa in enumerate(KAPPA):
        angles = plane_angles(np.exp(kappa * (log - middle)) * unit)
        difference = np.degrees(np.abs(angles - source[faces]).mean(axis=1))
        cost[:, i] = np.bincount(at, np.where((angles <= 0).any(axis=1), _FOLDED, difference), bins)
    return cost - cost[:, :1]


def plane_angles(z: ComplexArray) -> FloatArray:
    """Signed corner angles of triangles in the plane, (m, 3): negative where folded, 0 where corners coincide."""
    after, before = np.roll(z, -1, axis=1) - z, np.roll(z, 1, axis=1) - z
    return np.angle(before * after.conj())


def _equilateral() -> FloatArray:
    """Mean angle difference, in degrees, of equilateral triangles of all directions squashed by each kappa."""
    turn = np.exp(1j * (np.linspace(0, 2 * np.pi, 60, endpoint=False)[:, None] + np.arange(3) * 2 * np.pi / 3))
    return np.array([np.degrees(np.abs(np.abs(plane_angles(k * turn.real + 1j * turn.imag)) - np.pi / 3).mean())
                     for k in KAPPA])


EQUILATERAL = _equilateral()
