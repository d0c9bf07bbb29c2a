"""Maps to the sphere of least strain from one surface to another: from coarse levels to fine ones."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

from ..mesh.arrays import FloatArray
from ..newton.faces import FaceProblem, VertexTerm
from ..newton.loop import LineSearch, newton
from ..shapes.features import SurfacePair
from ..shapes.rotation import RotationCandidate
from ..sphere.moebius import best_rotation
from ..sphere.rows import inner, row_dots, weighted_sum
from ..untangle.local_repair import unfolded
from .fits import Misfit, fit_moebius
from .flow import meet
from .levels import Level
from .strain import ComposedStrain, Lift, log_strain

#: Points of the coarse levels. The first is fast enough for every start; from there to 10,000 and more vertices at once
#: faces in limbs are strained too much to come back.
_SIZES = (642, 2562)
#: Shares of the surfaces' metrics, beside the spheres', in turn; each with radians that features are smoothed by.
SHARES = {0.25: 0.5, 0.5: 0.3, 0.75: 0.2, 0.9: 0.12, 0.97: 0.07, 1.0: 0.04}
#: Weights of the sphere's strain: the least on the way, and at the end.
_GUARD, _LAST_GUARD = 0.05, 0.01
#: Newton steps at each share and at the end, at most, and the share of the energy below which two gains end them.
_STEPS, _LAST_STEPS, _GAIN = 5, 30, 2e-3

#: Weight of a soft landmark's squared chord: it leaves distances of some .01.
_SOFT = 10.0

#: Takes A's own mesh, or its refinement, each iterate on it, and its energy.
LevelReport = Callable[[Level, FloatArray, float], None]


class Descent:
    """Maps of A to B's sphere, lowered in strain from A to B, and what is to agree beside it.

    Parameters
    ----------
    a, b : Level
        The surfaces on their own meshes.
    goals : (k, 3) float64 array
        Points of B's sphere that A's landmarks are to meet.
    pair : SurfacePair
        Features, smoothed by the widths of `SHARES` and one before them.
    weights : (float, float)
        Weights of the features: on the way, and at the share 1.
    position_weight : float
        Weight of the squared distances between the surfaces' points, after a similarity.
    soft : bool
        Whether landmarks are drawn to their goals instead of being held there.
    guard : float
        Weight of the strain of A's sphere at the share 1.
    """

    def __init__(self, a: Level, b: Level, goals: FloatArray, pair: SurfacePair, weights: tuple[float, float], *,
                 position_weight: float = 0.0, soft: bool = False, guard: float = _LAST_GUARD) -> None:
        self._a, self._b, self._goals, self._soft = a, b, goals, soft
        self._pair, self._weights, self._position_weight, self._guard = pair, weights, position_weight, guard

    @cached_property
    def _levels(self) -> list[tuple[Level, Level]]:
        """Levels of A, each with one of B, its own mesh last."""
        coarse = [(self._a.coarser(size), self._b.coarser(size)) for size in _SIZES]
        return [*coarse, (self._a, self._b)]

    def start(self) -> tuple[FloatArray, tuple[RotationCandidate, ...]]:
        """A rotation of A's sphere with its Moebius map, and all rotations that were tried, its own first.

        On the coarsest level it leads to the least product of energy and distance of positions, which both vanish for
        similar surfaces. Energy alone is local: a body may be laid on another with its limbs exchanged, and be strained
        less.
        """
        candidates, (a, b) = self._pair.rotations(), self._levels[0]
        starts, values = [], []
        for candidate in candidates:
            starts.append(self._fitted(candidate))
            level, y = self.lowered(a, b, self._a.carried(starts[-1], a))
            terms = self._terms(level, b, y, len(SHARES))
            energy = log_strain(level, b, y) + sum(term.value(y) for term in terms)
            values.append(energy * _distance(level, b, y))
        best = int(np.argmin(values))
        return starts[best], (candidates[best], *(each for k, each in enumerate(candidates) if k != best))

    def _fitted(self, candidate: RotationCandidate) -> FloatArray:
        """A's sphere after a rotation, and the Moebius map that its features ask for."""
        found = [unfolded(self._a.mesh, self._a.x @ candidate.rotation.T)]  # rounding may fold slivers

        def keep(y: FloatArray, _: float) -> None:
            found[0] = y

        pair = self._pair
        fit_moebius(found[0], self._a.f, pair.weights, pair.features[0], pair.fixed_features(0), keep)
        return found[0]

    def run(self, start: FloatArray, report: LevelReport) -> tuple[Level, FloatArray]:
        """The map that a start on A's own mesh leads to, and that mesh, or its refinement near landmarks."""
        before, y = self._a, start
        for a, b in self._levels:
            before, y = self.lowered(a, b, before.carried(y, a), report if a is self._a else None)
        return before, y

    def lowered(self, a: Level, b: Level, y: FloatArray, report: LevelReport | None = None) -> tuple[Level, FloatArray]:
        """A map of a level with less strain, landmarks held at their goals, and the level, refined if they need it.

        If landmarks can't be brought to their goals, the map is the one that came nearest.
        """
        held = None
        if len(self._goals) and not self._soft:
            a, y = meet(a, y, self._goals)
            if not (y[a.landmarks] == self._goals).all():
                return a, y
            held = np.zeros(len(y), dtype=bool)
            held[a.landmarks] = True
        for number, share in enumerate(SHARES, 1):
            last = number == len(SHARES)
            strain = ComposedStrain(a, b, share, self._guard if last else max(_GUARD, self._guard))
            problem = FaceProblem(strain, self._terms(a, b, y, number), held=held)
            value, small = problem.value(y), 0
            for k, trial in enumerate(newton(problem, LineSearch(a.system), y), 1):
                y, gain, value = trial.x, value - trial.value, trial.value
                if report is not None:
                    report(a, y, value)
                small = small + 1 if gain < _GAIN * (value + gain) else 0
                if small == 2 or k == (_LAST_STEPS if last else _STEPS):
                    break
        return a, y

    def _terms(self, a: Level, b: Level, y: FloatArray, number: int) -> list[VertexTerm]:
        """What is to agree beside low strain at one of the shares."""
        terms: list[VertexTerm] = []
        areas = 4 * np.pi * a.mesh.A
        if weight := self._weights[number == len(SHARES)]:
            values = self._pair.features[number]
            if a.own is not None:
                values = a.own.at(a.x, values)
            terms.append(Misfit(weight * areas, values, self._pair.fixed_features(number)))
        if self._soft:
            weights, rows = np.zeros(len(y)), np.zeros_like(y)
            weights[a.landmarks], rows[a.landmarks] = _SOFT, self._goals
            terms.append(Misfit(weights, rows, _position))
        if self._position_weight:
            on_b = Lift(b.locator, b.v).values(y)
            scale = 4 * np.pi  # positions of a surface of area 4 pi, as strains are
            aligned = similar(on_b, a.v, a.mesh.A, b.v)
            terms.append(Misfit(self._position_weight * areas * scale, a.v, Lift(b.locator, aligned)))
        return terms


def _position(y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points of the sphere themselves, and their gradients."""
    return y, np.broadcast_to(np.eye(3), (len(y), 3, 3))


def _distance(a: Level, b: Level, y: FloatArray) -> float:
    """Root mean square of the distance between A's points and their places on B, after a similarity."""
    on_b = Lift(b.locator, b.v).values(y)
    off = similar(on_b, a.v, a.mesh.A, on_b) - a.v
    return float(np.sqrt(a.mesh.A @ row_dots(off, off)))


def similar(p: FloatArray, q: FloatArray, weights: FloatArray, points: FloatArray) -> FloatArray:
    """Points after the similarity that brings rows p nearest to rows q, in weighted squares (Procrustes)."""
    weights = weights / weights.sum()
    centre, goal = weighted_sum(weights, p), weighted_sum(weights, q)
    P, Q = p - centre, q - goal
    R = best_rotation(P, Q, weights)
    W = weights[:, None]
    scale = inner(W * (P @ R), Q) / inner(W * P, P)
    return np.asarray(scale * (points - centre) @ R + goal)
