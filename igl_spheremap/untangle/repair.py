"""The repair: from a map with foldings to one that is certified to have none, near the mesh's angles, in four steps.

1. *map*: the harmonic map is certified. Step 2 is left out if at most 1 percent of its faces are folded.
2. *angles*: the body is laid out in the plane by angles that close, which can't underflow, and put on the sphere. Limbs
   deeper than float64 are shortened (deep_limbs.py); where that costs angles, the deepest tips are first put where
   coordinates are finer (poles.py).
3. *embedding*: foldings that are left are repaired by small moves, or else by progressive embedding.
4. *newton*: damped Newton steps lower the angle differences of the whole map (effort.py: at what cost).

The map of a step is taken if it is certified and its angle differences are the least so far. A step that fails leaves
the map as it is, and a note. A poor map competes with layouts around several holes (candidates.py): each takes a few
rough steps, and the best goes on.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property
from itertools import chain, count
from operator import itemgetter

import numpy as np

from ..descent.energies import HarmonicEnergy
from ..errors import one_line
from ..mesh.arrays import HALF_DIGITS, FloatArray
from ..mesh.measure import surface_area
from ..mesh.timings import stage
from ..newton.loop import DAMPED
from ..newton.system import VertexSystem
from ..operators.laplacian import Operators
from ..result.run import Iterate, Listener, Round, Status
from ..result.sphere_map import SphereMap
from ..sphere.rows import weighted_sum
from ..start.punctured import is_coarse
from ..verify.certificate import Certificate
from ..verify.distortion import mean_angle_difference
from ..verify.signs import folded_faces
from .candidates import Badness, layouts, least_folded
from .deep_limbs import floors
from .effort import Effort
from .embedding import fix_orientation
from .layout import onto_sphere, unroll
from .local_repair import FEW, has_few_foldings, is_off_centre, is_worse, repair_locally, restore_gauge, small_moves
from .match_angles import GOOD, SMALL, is_worth_steps, match_angles, polish_map
from .poles import placements

#: One number for several: half the rough steps that compare candidates; candidates in a row without a gain, after
#: which no more are tried.
_SEVERAL = 3


@stage("repair")
def repair(first: SphereMap, operators: Operators, listener: Listener | None = None, *, polish: str | None = "auto",
           centred: bool = False, effort: Effort = Effort()) -> SphereMap:  # noqa: B008 - it is frozen
    """Free a map, in the gauge of the result, of foldings, and bring it nearer to the mesh's angles.

    Returns `first` if it is free of foldings, not poor, and steps are not asked for or would gain little. Bodies with
    limbs too deep for float64 get the gauge "poles", unless `centred`.
    """
    steps = _Steps(first, operators, listener, effort)
    with steps.attempt("repair"):
        mesh, x, free = first.mesh, first.sphere, first.certificate.folding_free
        few = free or has_few_foldings(first.certificate, mesh.f)
        small, medium = (len(mesh.v) <= n for n in (SMALL, (_SEVERAL + 1) * SMALL))
        coarse = is_coarse(surface_area(x, mesh.f)) or (medium and not few)
        poor = coarse and mean_angle_difference(mesh, x) > 2 * GOOD
        worth = polish == "angles" or bool(free and not poor and polish and is_worth_steps(mesh, x, harmonic=True))
        if free and not (poor or worth):
            steps.notify(x, first.energy, 0)
            return steps.result()
        steps.accept("map", x)
        if not free and few and not poor:
            with steps.attempt("embedding"):
                steps.accept("embedding", repair_locally(mesh, x))
            worth = worth or bool(polish and steps.found and is_worth_steps(mesh, steps.best.sphere))
        if poor or not few:
            with steps.attempt("angles"):
                deep, layout = steps.angles(centred, effort.holes if poor else 0)
                if poor and effort.holes and (small or not deep):
                    steps.compete(effort.holes, layout)
        # Angles are poor at the hole, which is a large part of a small mesh: the map itself is embedded there, too.
        if not steps.found or (small and not few and not steps.ends):
            with steps.attempt("embedding"):
                steps.accept("embedding", repair_locally(mesh, x))
        if steps.found and (poor or not few or worth):
            with steps.attempt("newton"):
                steps.newton()
        if steps.found and polish == "angles":
            with steps.attempt("polish"):
                steps.polish()
    return steps.result()


class _Steps:
    """The steps, and the best map so far."""

    #: Damping with which steps begin.
    damping = HALF_DIGITS
    #: The last candidate that has taken all its steps.
    done: SphereMap | None = None

    def __init__(self, first: SphereMap, operators: Operators, listener: Listener | None, effort: Effort) -> None:
        self.first, self.mesh, self.operators, self.listener = first, first.mesh, operators, listener
        self.effort, self.found = effort, list[tuple[float, SphereMap]]()
        self.ends = list[tuple[float, SphereMap]]()  # candidates after their first steps, with their mean differences
        self.rounds: list[Round] = []
        self.notes: list[str] = []
        self._began = time.perf_counter()

    @property
    def best(self) -> SphereMap:
        """The certified map of least angle differences."""
        return min(self.found, key=itemgetter(0))[1]

    @property
    def mean(self) -> float:
        """Its mean angle difference."""
        return min(mean for mean, _ in self.found)

    @property
    def least(self) -> float:
        """The least mean angle difference of a candidate after its first steps."""
        return min((mean for mean, _ in self.ends), default=np.inf)

    @cached_property
    def _system(self) -> VertexSystem:
        """Assembly of the systems with two unknowns a vertex."""
        return VertexSystem(self.mesh.f, len(self.mesh.v), limbs=True)

    @contextmanager
    def attempt(self, name: str) -> Iterator[None]:
        """A step; if it fails, leave the map as it is, and a note."""
        try:
            yield
        except StopIteration:  # by a listener
            raise
        except Exception as error:  # whatever it is, the map at hand is not lost
            self.notes.append(left_out(name, error))

    def accept(self, name: str, x: FloatArray, stretch: float = 1.0, gauge: str = "centred") -> bool:
        """Record a map; True if it is certified, and so may become the result."""
        certificate, mean = Certificate.of(x, self.mesh.f), mean_angle_difference(self.mesh, x)
        before = self.rounds[-1].foldings_after if self.rounds else certificate.foldings
        k, now, energy = len(self.rounds), time.perf_counter(), HarmonicEnergy(self.operators.L).evaluate(x)[0]
        self.rounds.append(Round(k, name, before, certificate.foldings, 0, energy, mean, Status.DONE,
                                 now - self._began))
        self._began = now
        self.notify(x, energy, certificate.foldings)
        if certificate.folding_free:
            run = replace(self.first.run, energy=energy, stretch=stretch, gauge=gauge)
            self.found.append((mean, SphereMap(self.mesh, x, certificate, run)))
        return certificate.folding_free

    def notify(self, x: FloatArray, energy: float, foldings: int) -> None:
        """Hand a map to the listener."""
        if self.listener is not None:
            self.listener(Iterate("repair", max(0, len(self.rounds) - 1), 0, x, energy, float(foldings)))

    def angles(self, centred: bool, holes: int) -> tuple[bool, FloatArray | None]:
        """Lay the body out by angles that close, its limbs as deep as float64 holds; whether they are deeper.

        With `holes`, a layout that is not deep is only one of the candidates, and is handed back.
        """
        placed = unroll(self.mesh, self.first.sphere, self._system)
        deep = placed is not None and bool(placed.depth.max() > floors(np.float64)[0])
        if placed is None or (holes and not deep):
            return deep, None if placed is None else onto_sphere(placed, placed.z)
        self.damping = DAMPED
        for y, stretch, gauge in placements(placed, self.mesh.angles, centred):
            if self.accept("angles", y, stretch, gauge):
                break
            before = self.rounds[-1].mean_angle_difference
            self.accept("embedding", repair_locally(self.mesh, y), stretch, gauge)
            if not is_worse(self.rounds[-1].mean_angle_difference, before):
                break
        return deep, None

    def compete(self, holes: int, layout: FloatArray | None) -> None:
        """Let the map itself, its layout, and layouts around so many other faces take steps, rough ones as a rule.

        Above 1,000 vertices, where few compete, a layout that is the best one as it is takes whole steps at once.
        """
        small, free = len(self.mesh.v) <= SMALL, self.first.certificate.folding_free
        few = min(2 * _SEVERAL, self.effort.systems)
        for name, y, mended in self._candidates(holes, layout):
            known = free and name == "map"
            if not (known or self.accept(name, y)
                    or self.accept("embedding", repair_locally(self.mesh, y, sweeps=5, mended=mended))):
                continue
            mean, start = self.found[0 if known else -1]
            itself = name == "map" and not self.ends  # not as the last resort
            whole = (small or not free) if itself else (not small and mean < self.least)
            effort = replace(self.effort, systems=self.effort.systems if itself or whole else few)
            with self.attempt("newton"):
                for _ in count() if small and whole else range(1):
                    x = match_angles(self.mesh, start.sphere, self._centroid(start), self._system, effort,
                                     damping=HALF_DIGITS, rough=not whole)
                    self.accept("newton", x)
                    if not self.found[-1][0] < (1 - self.effort.least_gain) * mean:
                        break
                    mean, start = self.found[-1]
            self.ends.append(min((mean, start), self.found[-1], key=itemgetter(0)))
            if whole:
                self.done = self.ends[-1][1]

    def _candidates(self, holes: int, layout: FloatArray | None) -> Iterator[tuple[str, FloatArray, FloatArray]]:
        """Maps to try, and what small moves make of them, until several in a row gain nothing.

        Those that small moves do not free of foldings are moved to the gauge that folds least, and left out above 1,000
        vertices, where embedding takes long, if there is another.
        """
        badness, f, n = Badness(self.mesh), self.mesh.f, len(self.mesh.v)
        x, small = fix_orientation(self.first.sphere, f), n <= SMALL
        mended = small_moves(x, f)
        if badness.folded(x) <= FEW and (small or not folded_faces(mended, f).any()):
            yield "map", x, mended
            if self.least < (2 * GOOD if small else GOOD):
                return
        wanted, tried, idle = max(len(self.ends) + 1, holes * SMALL // (2 * n)), set[float](), 0
        left = list[tuple[float, FloatArray, FloatArray]]()
        for y in chain([] if layout is None else [layout], layouts(self.mesh, self._system, holes)):
            bad = badness(y)
            if round(bad, 6) in tried:  # around the same face
                continue
            tried.add(round(bad, 6))
            mended = small_moves(y, f)
            if badness.folded(mended):
                bad, y = least_folded(y, badness)
                mended = small_moves(y, f)
            least, before = self.least, len(self.ends)
            if small or not folded_faces(mended, f).any():
                yield "angles", y, mended
            if len(self.ends) == before:
                left.append((bad, y, mended))
            else:
                idle = 0 if self.least < (1 - self.effort.least_gain) * least else idle + 1
            if idle == _SEVERAL or (not small and len(self.ends) >= wanted):
                break
        if small and badness.folded(x) > FEW and 5 * GOOD < self.least < np.inf:
            yield "map", x, small_moves(x, f)
        if not self.found and left:
            yield "angles", *min(left, key=lambda entry: entry[0])[1:]

    def newton(self) -> None:
        """Lower the angle differences of the map and of the best one, or of the best candidates, by runs of steps.

        Maps that need no repair are improved by few steps. Up to 1,000 vertices, and where candidates competed, the
        best map takes further runs while they gain.
        """
        if self.best is self.done:
            return
        n, small = len(self.mesh.v), len(self.mesh.v) <= SMALL
        effort = self.effort
        if self.first.certificate.folding_free and not self.ends:
            effort = replace(effort, systems=min(effort.systems, 1 + _SEVERAL * SMALL // n))
        starts = [self.found[0][1], self.best]
        if self.ends:
            ends = sorted(self.ends, key=itemgetter(0))  # one in a hundred wins that is further off
            starts = [self.best, *(end for mean, end in ends if end is not self.done and mean < 4 / 3 * self.mean)]
        starts = list(dict.fromkeys(starts))[:2 if small or not self.ends else 1]
        for run in count():
            before = self.mean
            for start in starts:
                x = match_angles(self.mesh, start.sphere, self._centroid(start), self._system, effort,
                                 damping=self.damping)
                self.accept("newton", x, start.run.stretch, start.run.gauge)
            gained = self.mean < (1 - effort.least_gain) * before
            if not ((small or self.ends) and (gained or (small and run == 0))):
                return
            starts = [self.best]

    def _centroid(self, start: SphereMap) -> FloatArray:
        """Where steps are to keep the centroid of the source's area."""
        held = start.gauge == "poles" or is_off_centre(self.mesh, start.sphere)
        return weighted_sum(self.mesh.A, start.sphere) if held else np.zeros(3)

    def polish(self) -> None:
        """Lower the angle differences further."""
        best = self.best
        self.accept("polish", polish_map(self.mesh, best.sphere, self.effort), best.stretch, best.gauge)

    def result(self) -> SphereMap:
        """The best map, in the package's gauge."""
        best = self.best if self.found else self.first
        if best.sphere is not self.first.sphere and best.gauge == "centred":
            with self.attempt("gauge"):
                self.found.append((-1.0, self._in_gauge(best)))
            best = self.best
        best = self.first if best.sphere is self.first.sphere else best
        rounds = tuple(self.rounds) if len(self.rounds) > 1 else ()
        return replace(best, run=replace(best.run, rounds=rounds, notes=(*best.notes, *self.notes)))

    def _in_gauge(self, found: SphereMap) -> SphereMap:
        x = restore_gauge(self.mesh, found.sphere, not self.ends or len(self.mesh.v) <= SMALL)
        run = replace(found.run, energy=HarmonicEnergy(self.operators.L).evaluate(x)[0])
        return replace(found, sphere=x, certificate=Certificate.of(x, self.mesh.f), run=run)


def left_out(name: str, error: Exception) -> str:
    """The note on a step that failed."""
    return f"the step {name} failed and was left out, please report it: {one_line(error)}"
