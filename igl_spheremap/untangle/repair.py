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
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property

import numpy as np

from ..descent.energies import HarmonicEnergy
from ..errors import one_line
from ..mesh.arrays import HALF_DIGITS, FloatArray
from ..mesh.measure import corner_angles
from ..mesh.timings import stage
from ..newton.loop import DAMPED
from ..newton.system import VertexSystem
from ..operators.laplacian import Operators
from ..result.run import Iterate, Listener, Round, Status
from ..result.sphere_map import SphereMap
from ..sphere.rows import weighted_sum
from ..verify.certificate import Certificate
from ..verify.distortion import mean_difference
from .deep_limbs import floors, shorten_limbs
from .effort import Effort
from .layout import Placed, onto_sphere, unroll
from .local_repair import has_few_foldings, is_worse, repair_locally, restore_gauge
from .match_angles import SMALL, is_worth_steps, match_angles
from .poles import at_poles

#: Number of runs of steps on small meshes, each from the end of the last; and of steps on maps that came without
#: foldings, which cost three to four times the map then.
_SEVERAL = 3


@stage("repair")
def repair(first: SphereMap, operators: Operators, listener: Listener | None = None, *,
           centred: bool = False, effort: Effort = Effort()) -> SphereMap:  # noqa: B008 - it is frozen
    """Free a map, in the gauge of the result, of foldings, and bring it nearer to the mesh's angles.

    Returns `first` if it is free of foldings and steps would gain little. Bodies with limbs too deep for float64 get
    the gauge "poles", unless `centred`.
    """
    mesh, x = first.mesh, first.sphere
    steps = _Steps(first, operators, listener)
    free = first.certificate.folding_free
    if free and not is_worth_steps(mesh, x):
        steps.notify(x, first.energy, 0)
        return first
    steps.accept("map", x)
    if not free:
        few = has_few_foldings(first.certificate, mesh.f)
        if not few:
            steps.attempt("angles", lambda: steps.angles(centred))
        # Angles are poor at the hole, which is a large part of a small mesh: the map itself is embedded there, too.
        if steps.best is None or (not few and len(mesh.v) <= SMALL):
            steps.attempt("embedding", lambda: steps.accept("embedding", repair_locally(mesh, x)))
    for _ in range(_SEVERAL if len(mesh.v) <= SMALL else 1):
        steps.attempt("newton", lambda: steps.newton(effort))
    return steps.result()


class _Steps:
    """The steps, and the best map so far."""

    best: SphereMap | None = None
    laid_out: Placed | None = None

    def __init__(self, first: SphereMap, operators: Operators, listener: Listener | None) -> None:
        self.first, self.mesh, self.operators, self.listener = first, first.mesh, operators, listener
        self.rounds: list[Round] = []
        self.notes: list[str] = []
        self._began, self._least = time.perf_counter(), np.inf

    @cached_property
    def _system(self) -> VertexSystem:
        """Assembly of the systems with two unknowns a vertex."""
        return VertexSystem(self.mesh.f, len(self.mesh.v), limbs=True)

    @cached_property
    def _source(self) -> FloatArray:
        """Corner angles of the mesh."""
        return corner_angles(self.mesh.v, self.mesh.f)

    def attempt(self, name: str, step: Callable[[], object]) -> None:
        """Take a step; if it fails, leave the map as it is, and a note."""
        try:
            step()
        except StopIteration:  # by a listener
            raise
        except Exception as error:  # whatever it is, the map at hand is not lost
            self.notes.append(left_out(name, error))

    def accept(self, name: str, x: FloatArray, stretch: float = 1.0, gauge: str = "centred") -> bool:
        """Record a map; take it if it is certified and its angle differences are the least so far."""
        certificate, surface = Certificate.of(x, self.mesh.f), self.mesh.surface
        mean = mean_difference(self._source[surface], x, self.mesh.f[surface])
        before = self.rounds[-1].foldings_after if self.rounds else certificate.foldings
        k, now, energy = len(self.rounds), time.perf_counter(), HarmonicEnergy(self.operators.L).evaluate(x)[0]
        self.rounds.append(Round(k, name, before, certificate.foldings, 0, energy, mean, Status.CONVERGED,
                                 now - self._began))
        self._began = now
        self.notify(x, energy, certificate.foldings)
        taken = certificate.folding_free and mean < self._least
        if taken:
            run = replace(self.first.run, energy=energy, stretch=stretch, gauge=gauge)
            self.best, self._least = SphereMap(self.mesh, x, certificate, run), mean
        return taken

    def notify(self, x: FloatArray, energy: float, foldings: int) -> None:
        """Hand a map to the listener."""
        if self.listener is not None:
            self.listener(Iterate("repair", max(0, len(self.rounds) - 1), 0, x, energy, float(foldings)))

    def angles(self, centred: bool) -> None:
        """Angles that close, and their layout, its limbs as deep as float64 holds."""
        self.laid_out = unroll(self.mesh, self.first.sphere, self._system)
        if self.laid_out is None:
            return
        for y, stretch, gauge in self._placements(self.laid_out, centred):
            if not self.accept("angles", y, stretch, gauge):
                before = self.rounds[-1].mean_angle_difference
                self.accept("embedding", repair_locally(self.mesh, y), stretch, gauge)
                if is_worse(self.rounds[-1].mean_angle_difference, before):
                    continue
            return

    def _placements(self, placed: Placed, centred: bool) -> Iterator[tuple[FloatArray, float, str]]:
        """Maps to try one after the other, their limbs shortened ever more, with stretch and gauge."""
        deepest, *shallower = floors(np.float64)
        gauge, shortened = "centred", shorten_limbs(placed, self._source, deepest)
        if shortened.cost > 0 and not centred:
            gauge, placed = "poles", at_poles(placed, deepest)
            shortened = shorten_limbs(placed, self._source, deepest)
        yield onto_sphere(placed, shortened.z), shortened.stretch, gauge
        for floor in shallower:
            shortened = shorten_limbs(placed, self._source, floor)
            yield onto_sphere(placed, shortened.z), shortened.stretch, gauge

    def newton(self, effort: Effort) -> None:
        """Lower the angle differences of the best map.

        If it came without foldings, factorised steps are at most 1 + 3000 // n, and above 4,000 vertices, where
        factorisations take most of the time, there are three quick steps by conjugate gradients.
        """
        if self.best is None:
            return
        x, run, n, quick = self.best.sphere, self.best.run, len(self.mesh.v), False
        if self.first.certificate.folding_free:
            quick = n > (_SEVERAL + 1) * SMALL
            effort = replace(effort, systems=min(effort.systems, _SEVERAL if quick else 1 + _SEVERAL * SMALL // n))
        centroid = weighted_sum(self.mesh.A, x) if run.gauge == "poles" else np.zeros(3)
        x = match_angles(self.mesh, x, centroid, self._system, effort,
                         damping=HALF_DIGITS if self.laid_out is None else DAMPED, quick=quick)
        self.accept("newton", x, run.stretch, run.gauge)

    def result(self) -> SphereMap:
        """The best map, in the package's gauge."""
        if self.best is not None and self.best.sphere is not self.first.sphere and self.best.gauge == "centred":
            self.attempt("gauge", self._restore_gauge)
        best = self.best if self.best is not None and self.best.sphere is not self.first.sphere else self.first
        rounds = tuple(self.rounds) if len(self.rounds) > 1 else ()
        return replace(best, run=replace(best.run, rounds=rounds, notes=(*best.notes, *self.notes)))

    def _restore_gauge(self) -> None:
        assert self.best is not None
        x = restore_gauge(self.mesh, self.best.sphere)
        run = replace(self.best.run, energy=HarmonicEnergy(self.operators.L).evaluate(x)[0])
        self.best = replace(self.best, sphere=x, certificate=Certificate.of(x, self.mesh.f), run=run)


def left_out(name: str, error: Exception) -> str:
    """The note on a step that failed."""
    return f"the step {name} failed and was left out, please report it: {one_line(error)}"
