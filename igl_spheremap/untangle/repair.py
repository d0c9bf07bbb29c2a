"""The repair: from a map with foldings to one that is certified to have none, near the mesh's angles, in four steps.

1. *map*: the harmonic map is certified. Step 2 is left out if at most 1 percent of its faces are folded.
2. *angles*: the body is laid out in the plane by angles that close, which can't underflow, and put on the sphere. Limbs
   deeper than float64 are shortened (deep_limbs.py); where that costs angles, the deepest tips are first put where
   coordinates are finer (poles.py).
3. *embedding*: foldings that are left are repaired by small moves, or else by progressive embedding.
4. *newton*: damped Newton steps lower the angle differences of the whole map (effort.py: at what cost).

The map of a step is taken if it is certified and its angle differences are the least so far. A step that fails leaves
the map as it is, and a note.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property

import numpy as np

from ..descent.energies import HarmonicEnergy
from ..errors import one_line
from ..mesh.arrays import HALF_DIGITS, FloatArray
from ..mesh.measure import corner_angles, surface_area
from ..mesh.timings import stage
from ..newton.loop import DAMPED
from ..newton.system import VertexSystem
from ..operators.laplacian import Operators
from ..result.run import Iterate, Listener, Round, Status
from ..result.sphere_map import SphereMap
from ..sphere.rows import weighted_sum
from ..start.punctured import is_coarse
from ..verify.certificate import Certificate
from ..verify.distortion import mean_difference
from .candidates import Badness, layouts, least_folded
from .deep_limbs import floors, shorten_limbs
from .effort import Effort
from .layout import Placed, onto_sphere, unroll
from .local_repair import has_few_foldings, is_off_centre, is_worse, repair_locally, restore_gauge
from .match_angles import GOOD, SMALL, is_worth_steps, match_angles, polish_map
from .poles import at_poles

#: Runs of steps on small meshes at the most, each from the end of the last; and quick steps in a run.
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
        poor = is_coarse(surface_area(x, mesh.f)) and steps.mean(x) > 2 * GOOD
        if free and not poor and not (polish and is_worth_steps(mesh, x)) and polish != "angles":
            steps.notify(x, first.energy, 0)
            return steps.result()
        steps.accept("map", x)
        if not free and few and (not poor or len(mesh.v) <= SMALL):
            with steps.attempt("embedding"):
                steps.accept("embedding", repair_locally(mesh, x))
        if poor or not few:
            with steps.attempt("angles"):
                steps.angles(centred, effort.holes if poor else 0)
        # Angles are poor at the hole, which is a large part of a small mesh: the map itself is embedded there, too.
        if not steps.found or (not few and len(mesh.v) <= SMALL):
            with steps.attempt("embedding"):
                steps.accept("embedding", repair_locally(mesh, x))
        if steps.found and (poor or not few or (polish and is_worth_steps(mesh, steps.best.sphere))):
            with steps.attempt("newton"):
                steps.newton(quick=few and not poor)
        if steps.found and polish == "angles":
            with steps.attempt("polish"):
                steps.polish()
    return steps.result()


class _Steps:
    """The steps, and the best map so far."""

    laid_out = False

    def __init__(self, first: SphereMap, operators: Operators, listener: Listener | None, effort: Effort) -> None:
        self.first, self.mesh, self.operators, self.listener = first, first.mesh, operators, listener
        self.effort, self.found = effort, list[tuple[float, SphereMap]]()
        self.rounds: list[Round] = []
        self.notes: list[str] = []
        self._began = time.perf_counter()

    @property
    def best(self) -> SphereMap:
        """The certified map of least angle differences."""
        return min(self.found, key=lambda entry: entry[0])[1]

    @cached_property
    def _system(self) -> VertexSystem:
        """Assembly of the systems with two unknowns a vertex."""
        return VertexSystem(self.mesh.f, len(self.mesh.v), limbs=True)

    @cached_property
    def _source(self) -> FloatArray:
        """Corner angles of the mesh."""
        return corner_angles(self.mesh.v, self.mesh.f)

    @contextmanager
    def attempt(self, name: str) -> Iterator[None]:
        """A step; if it fails, leave the map as it is, and a note."""
        try:
            yield
        except StopIteration:  # by a listener
            raise
        except Exception as error:  # whatever it is, the map at hand is not lost
            self.notes.append(left_out(name, error))

    def mean(self, x: FloatArray) -> float:
        """Mean angle difference of a map, in degrees, over the faces that are no caps."""
        surface = self.mesh.surface
        return mean_difference(self._source[surface], x, self.mesh.f[surface])

    def accept(self, name: str, x: FloatArray, stretch: float = 1.0, gauge: str = "centred") -> bool:
        """Record a map; True if it is certified, and so may become the result."""
        certificate, mean = Certificate.of(x, self.mesh.f), self.mean(x)
        before = self.rounds[-1].foldings_after if self.rounds else certificate.foldings
        k, now, energy = len(self.rounds), time.perf_counter(), HarmonicEnergy(self.operators.L).evaluate(x)[0]
        self.rounds.append(Round(k, name, before, certificate.foldings, 0, energy, mean, Status.CONVERGED,
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

    def angles(self, centred: bool, holes: int) -> None:
        """Angles that close, and their layout, its limbs as deep as float64 holds.

        Layouts around other holes compete with it, the least folded of which are repaired.
        """
        placed = unroll(self.mesh, self.first.sphere, self._system)
        self.laid_out = placed is not None
        holes = min(holes, max(1, holes * SMALL // len(self.mesh.v))) if holes else 0
        if placed is not None and (not holes or placed.depth.max() > floors(np.float64)[0]):
            for y, stretch, gauge in self._placements(placed, centred):
                if not self.accept("angles", y, stretch, gauge):
                    before = self.rounds[-1].mean_angle_difference
                    self.accept("embedding", repair_locally(self.mesh, y), stretch, gauge)
                    if is_worse(self.rounds[-1].mean_angle_difference, before):
                        continue
                return
            return
        maps = [] if placed is None else [onto_sphere(placed, placed.z)]
        maps += layouts(self.mesh, self._system, holes)
        badness = Badness(self.mesh)
        tried = (least_folded(y, badness) for y in sorted(maps, key=badness)[:_SEVERAL])
        for _, y in sorted(tried, key=lambda entry: entry[0])[:2]:
            if self.accept("angles", y):
                return
            before = self.rounds[-1].mean_angle_difference
            self.accept("embedding", repair_locally(self.mesh, y, sweeps=5))
            if not is_worse(self.rounds[-1].mean_angle_difference, before):
                return

    def _placements(self, placed: Placed, centred: bool) -> Iterator[tuple[FloatArray, float, str]]:
        """Maps to try one after the other, their limbs shortened ever more, with stretch and gauge."""
        deepest, *shallower = floors(np.float64)
        gauge, shortened = "centred", shorten_limbs(placed, self._source, deepest)
        if shortened.cost > 0 and not centred:
            gauge, placed = "poles", at_poles(placed, deepest)
            shortened = shorten_limbs(placed, self._source, deepest)
        yield onto_sphere(placed, shortened.z), shortened.stretch, gauge
        # Where limbs are twice as deep as float64 holds, the floors differ by nothing that matters.
        for floor in shallower if placed.depth.max() < 2 * deepest else ():
            shortened = shorten_limbs(placed, self._source, floor)
            yield onto_sphere(placed, shortened.z), shortened.stretch, gauge

    def newton(self, quick: bool) -> None:
        """Lower the angle differences of the map and of the best one, then further those of the best on small meshes.

        Maps that need no repair are improved by few factorised steps, and above 4,000 vertices, where factorisations
        take most of the time, by quick steps with conjugate gradients.
        """
        n, effort, damping = len(self.mesh.v), self.effort, DAMPED if self.laid_out else HALF_DIGITS
        quick, slow = quick and n > (_SEVERAL + 1) * SMALL, not quick
        if not slow or self.first.certificate.folding_free:
            effort = replace(effort, systems=min(effort.systems, _SEVERAL if quick else 1 + _SEVERAL * SMALL // n))
        starts = [self.best] if self.best is self.found[0][1] else [self.found[0][1], self.best]
        for k in range(len(starts) + (_SEVERAL - 1 if n <= SMALL else 0)):
            start = starts[k] if k < len(starts) else self.best
            before = self.mean(start.sphere)
            x, run = start.sphere, start.run
            held = run.gauge == "poles" or is_off_centre(self.mesh, x)
            centroid = weighted_sum(self.mesh.A, x) if held else np.zeros(3)
            x = match_angles(self.mesh, x, centroid, self._system, effort, damping=damping, quick=quick)
            self.accept("newton", x, run.stretch, run.gauge)
            if k >= len(starts) and self.rounds[-1].mean_angle_difference > (1 - effort.least_gain) * before:
                return

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
        x = restore_gauge(self.mesh, found.sphere)
        run = replace(found.run, energy=HarmonicEnergy(self.operators.L).evaluate(x)[0])
        return replace(found, sphere=x, certificate=Certificate.of(x, self.mesh.f), run=run)


def left_out(name: str, error: Exception) -> str:
    """The note on a step that failed."""
    return f"the step {name} failed and was left out, please report it: {one_line(error)}"
