"""Maps to the sphere of least strain from one surface to another: from coarse levels to fine ones."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from itertools import accumulate, groupby
from typing import NamedTuple

import numpy as np

from ...mesh.arrays import FloatArray
from ...mesh.edges import marked
from ...newton.faces import FaceProblem, VertexTerm
from ...newton.loop import LineSearch, newton
from ...sphere.moebius import best_rotation
from ...sphere.rows import inner, row_dots, weighted_sum
from ...timings import counted, log_share
from ...untangle.local_repair import unfolded
from ..harmonics.rotation import RotationCandidate
from .features import FeaturePair
from .fits import Misfit
from .flow import meet
from .levels import Level
from .strain import ComposedStrain, log_strain


class Objective(NamedTuple):
    """Function to lower on a level.

    Attributes
    ----------
    size : int, optional
        Points of the level; the surfaces' own meshes without one.
    share : float
        Of the surfaces' metrics beside the spheres': at 0 rotations are minima, at 1 the spheres have no part.
    widths : tuple of float
        Widths of the features' smoothing, radians of a sphere of the surface's area.
    weight : float
        Of the features' squared differences, summed over all columns, beside the strain.
    guard : float
        Weight of the strain of the source's sphere, which alone knows the side of a face.
    steps : int
        Newton steps at most.
    """

    size: int | None
    share: float
    widths: tuple[float, ...]
    weight: float
    guard: float
    steps: int

    def work(self, own: int) -> int:
        """Points of the level, given their number on the surface's own mesh."""
        if self.size is None:
            return own
        return self.size


#: Takes the objective, the level, an iterate on it, and its energy.
LevelListener = Callable[[Objective, Level, FloatArray, float], None]


class Descent:
    """Lowers strain between two surfaces, and misfits of features, over maps to the target's sphere.

    Parameters
    ----------
    source, target : Level
        The surfaces on their own meshes.
    objectives : sequence of Objective
        From coarse levels to fine ones.
    pair : FeaturePair
        Their features.
    goals : (k, 3) float64 array
        Points of the target's sphere that the source's landmarks are to meet.
    soft : bool
        Whether landmarks are drawn to their goals instead of being held there.
    """

    def __init__(
        self,
        source: Level,
        target: Level,
        objectives: Sequence[Objective],
        pair: FeaturePair,
        goals: FloatArray,
        soft: bool = False,
    ) -> None:
        self.source, self.target, self.pair = source, target, pair
        self._goals, self._soft = goals, soft
        by_size = groupby(objectives, key=lambda objective: objective.size)
        self._plan = [(size, list(each)) for size, each in by_size]
        self._levels: dict[int | None, tuple[Level, Level]] = {None: (source, target)}

    def start(
        self, width: float, moebius: bool = False, least: float = 0.0
    ) -> tuple[FloatArray, tuple[RotationCandidate, ...]]:
        """Rotate the source's sphere by features of one width; return it and all rotations, the chosen one first.

        `moebius` adds the Moebius map that fits these features. The rotation with the least product of energy and
        distance of positions on the coarsest level is taken; both vanish for similar surfaces. Energy alone is local: a
        body may be registered to another with its limbs exchanged, and be strained less. Only rotations with at least
        the share `least` of the best correlation are tried.
        """
        candidates = self.pair.rotations(width)
        starts = [
            self.turned(each.rotation)
            for each in candidates
            if each.correlation >= least * candidates[0].correlation
        ]
        if moebius:
            starts = [self.pair.fit_moebius(start, width) for start in starts]
        best = 0
        if len(starts) > 1:
            best = int(np.argmin([self.outlook(start) for start in counted("starts", starts)]))
        chosen = candidates.pop(best)
        return starts[best], (chosen, *candidates)

    def turned(self, rotation: FloatArray) -> FloatArray:
        """Rotate the source's sphere."""
        # rounding may fold slivers
        return unfolded(self.source.map.mesh, self.source.map.sphere @ rotation.T)

    def coarsest(self) -> tuple[Level, Level]:
        """Return both surfaces at the first resolution."""
        return self._level(self._plan[0][0])

    def outlook(self, start: FloatArray) -> float:
        """Lower a start on the coarsest level, and return its energy times its distance of positions."""
        objectives = self._plan[0][1]
        source, target = self.coarsest()
        source, y = self.lowered(source, target, self.source.carried(start, source), objectives)
        terms = self._terms(source, target, y, objectives[-1])
        energy = log_strain(source, target, y) + sum(term.value(y) for term in terms)
        return energy * distance_between(source, target, y)

    def run(self, start: FloatArray, listener: LevelListener) -> tuple[Level, FloatArray]:
        """Lower a start on the source's own mesh through all levels; return the last one, maybe split, and the map."""
        own, steps = len(self.source.map.sphere), Counter[Objective]()
        plan = [objective for _, objectives in self._plan for objective in objectives]
        *before, total = accumulate(
            (objective.work(own) * objective.steps for objective in plan), initial=0
        )
        ahead = dict(zip(plan, before, strict=True))

        def take(objective: Objective, level: Level, y: FloatArray, energy: float) -> None:
            log_share("steps", ahead[objective] + objective.work(own) * steps[objective], total)
            steps[objective] += 1
            listener(objective, level, y, energy)

        level, y = self.source, start
        for size, objectives in self._plan:
            source, target = self._level(size)
            level, y = self.lowered(source, target, level.carried(y, source), objectives, take)
        log_share("steps", total, total)
        return level, y

    def _level(self, size: int | None) -> tuple[Level, Level]:
        """Return both surfaces at a resolution, which are made once."""
        if size not in self._levels:
            assert size is not None
            self._levels[size] = self.source.coarser(size), self.target.coarser(size)
        return self._levels[size]

    def lowered(
        self,
        source: Level,
        target: Level,
        y: FloatArray,
        objectives: Sequence[Objective],
        listener: LevelListener | None = None,
        enough: float = 2e-3,
    ) -> tuple[Level, FloatArray]:
        """Bring landmarks to their goals, hold them, and lower the strain; return the level, maybe split, and the map.

        If landmarks can't be brought to their goals, the nearest map is returned. When two steps in turn gain less than
        the share `enough` of their energy each, steps towards an objective end.
        """
        held = None
        if len(self._goals) and not self._soft:
            source, y = meet(source, y, self._goals)
            if not (y[source.landmarks] == self._goals).all():
                return source, y
            held = marked(source.landmarks, len(y))
        for objective in objectives:
            strain = ComposedStrain(source, target, objective.share, objective.guard)
            problem = FaceProblem(strain, self._terms(source, target, y, objective), held=held)
            value, small = problem.value(y), 0
            for k, trial in enumerate(newton(problem, LineSearch(source.system), y), 1):
                y, gain, value = trial.x, value - trial.value, trial.value
                if listener is not None:
                    listener(objective, source, y, value)
                small += 1
                if gain >= enough * (value + gain):
                    small = 0
                if small == 2 or k == objective.steps:
                    break
        return source, y

    def _terms(
        self, source: Level, target: Level, y: FloatArray, objective: Objective
    ) -> list[VertexTerm]:
        """Return the misfits that count beside the strain."""
        terms: list[VertexTerm] = []
        if objective.weight:
            values = self.pair.source(objective.widths)
            if source.own is not None:
                values = source.own.at(source.map.sphere, values)
            weights = objective.weight * (4 * np.pi * source.map.mesh.A)
            terms.append(Misfit(weights, values, self.pair.target(objective.widths)))
        if self._soft:
            weights, rows = np.zeros(len(y)), np.zeros_like(y)
            # ten times the squared chord leaves distances of some .01
            weights[source.landmarks], rows[source.landmarks] = 10.0, self._goals
            terms.append(Misfit(weights, rows, _position))
        return terms


def _position(y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points of the sphere as values over it, and their gradients."""
    return y, np.broadcast_to(np.eye(3), (len(y), 3, 3))


def distance_between(source: Level, target: Level, y: FloatArray) -> float:
    """Measure the root mean square distance of the source's points from their images, after a similarity.

    It is the one that brings the images nearest in weighted squares (Procrustes).
    """
    mesh, there = source.map.mesh, target.at(y, target.map.mesh.unit)
    weights = mesh.A / mesh.A.sum()
    goal = weighted_sum(weights, mesh.unit)
    P, Q = there - weighted_sum(weights, there), mesh.unit - goal
    R = best_rotation(P, Q, weights)
    W = weights[:, None]
    scale = inner(W * (P @ R), Q) / inner(W * P, P)
    off = scale * P @ R + goal - mesh.unit
    return float(np.sqrt(mesh.A @ row_dots(off, off)))
