"""The repair: from a map with foldings to one that is certified to have none, near the mesh's angles.

A plan (plan.py) says whether a map is to stay as it is, and else which maps start; they race (race.py):

1. *map*: the map itself, if at most 1 percent of its faces fold.
2. *angles*: the body laid out in the plane by angles that close, which can't underflow, and put on the sphere. Of
   limbs deeper than float64 the deepest tips are put where coordinates are finer (poles.py), and what is still too deep
   is shortened (deep_limbs.py). If no limb is deep, layouts around other holes follow (candidates.py).
3. *embedding*: what is folded starts after it was repaired by small moves, or else by progressive embedding; layouts
   that small moves don't suffice for start after the others, and a map that mostly folds starts last.
4. *newton*: damped Newton steps lower the angle differences of the whole map (effort.py: at what cost).

A map enters or replaces another one only if it is certified. A step that fails leaves the map as it is, and a note.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property, partial
from itertools import chain, islice
from operator import attrgetter

import numpy as np

from ..descent.energies import HarmonicEnergy
from ..errors import FactorisationFailed, MapError, MeshError, OfListener, one_line
from ..mesh.arrays import HALF_DIGITS, FloatArray
from ..mesh.check import Mesh
from ..newton.loop import DAMPED
from ..newton.system import VertexSystem
from ..operators.laplacian import Operators
from ..result.run import Iterate, Listener, Round, Run, Status
from ..sphere.rows import weighted_sum
from ..timings import phase
from ..untangle.local_repair import is_off_centre, repair_locally, restore_gauge
from ..verify.certificate import Certificate
from ..verify.distortion import mean_angle_difference
from .candidates import layouts, unfolded_first
from .deep_limbs import floor_of
from .effort import Effort
from .layout import Placed, unroll
from .match_angles import match_angles
from .plan import POOR, Plan
from .poles import on_float64
from .race import Candidate, race

#: Rough steps, which compare candidates, end when all further ones are predicted to gain less than this share. With .05
#: the set tune takes 1.05 of the time and ends the same: a sum of means of 1,008.6, not 1,008.2, 3 parts worse and 2
#: better (`python -m benchmarks versions . FOLDER/tune --set angles.repair._ROUGH_GAIN=.05`); with .2 it ends .4
#: percent higher, 7 worse and 1 better.
_ROUGH_GAIN = 0.1
#: What a step raises where arithmetic or memory fails it. All else, such as a caller's time limit, ends the call.
_FAILURES = (
    FactorisationFailed,
    MapError,
    MeshError,
    ArithmeticError,
    np.linalg.LinAlgError,
    MemoryError,
)


@phase("repair")
def repair(
    mesh: Mesh,
    x: FloatArray,
    certificate: Certificate,
    run: Run,
    plan: Plan,
    operators: Operators,
    listener: Listener | None = None,
    *,
    centred: bool = False,
    effort: Effort = Effort(),  # noqa: B008
) -> tuple[FloatArray, Certificate, Run]:
    """Carry out a plan: free a map of foldings, improve its angles, and put it in the gauge of the result.

    Bodies with limbs too deep for float64 get the gauge "poles", unless `centred`.
    """
    work = _Repair(mesh, x, certificate, run, plan, operators, listener, centred, effort)
    field: list[Candidate] = []
    try:
        with work.attempt("repair"):
            field = work.field()
            if field and np.isfinite(plan.price):
                field = [race(field, partial(work.steps, least_gain=plan.price), plan.price)]
        return work.result(field)
    except OfListener as raised:
        if isinstance(raised.error, StopIteration):
            raise raised.error from None
        raise


class _Repair:
    """A plan that is carried out, and the record of what happened."""

    def __init__(
        self,
        mesh: Mesh,
        x: FloatArray,
        certificate: Certificate,
        run: Run,
        plan: Plan,
        operators: Operators,
        listener: Listener | None,
        centred: bool,
        effort: Effort,
    ) -> None:
        self.mesh, self.x, self.certificate = mesh, x, certificate
        self.run, self.plan, self.operators = run, plan, operators
        self.listener, self.centred, self.effort = listener, centred, effort
        self.rounds: list[Round] = []
        self.notes: list[str] = []
        self._began = time.perf_counter()

    @cached_property
    def _system(self) -> VertexSystem:
        """Assembly of the systems with two unknowns a vertex."""
        backend = self.operators.factor.backend
        return VertexSystem(self.mesh.f, len(self.mesh.v), backend, limbs=True)

    @contextmanager
    def attempt(self, name: str) -> Iterator[None]:
        """A step; if it fails, leave the map as it is, and a note."""
        try:
            yield
        except _FAILURES as error:
            self.notes.append(left_out(name, error))

    def field(self) -> list[Candidate]:
        """The candidates after rough steps, which predict nothing of whole ones, if several may start."""
        field, plan = list[Candidate](), self.plan
        for start in islice(self.starts(), plan.starts):
            field.append(
                start
                if plan.starts == 1
                else replace(self.steps(start, _ROUGH_GAIN, True), further=np.inf)
            )
            if field[-1].mean <= POOR:
                break
        if not field and (last := self.embedded(self.x)):
            field = [last]
        return field

    def starts(self) -> Iterator[Candidate]:
        """Candidates in the order in which they start, each made when it is asked for."""
        first = self.record("map", self.x, self.certificate)
        if self.plan.itself and (start := first or self.embedded(self.x)):
            yield start
        if self.plan.layouts:
            with self.attempt("angles"):
                placed = unroll(self.mesh, self.x, self._system)
                if placed is not None and placed.depth.max() > floor_of(np.float64):
                    y, stretch, gauge = on_float64(placed, self.mesh.angles, self.centred)
                    if start := self.record("angles", y, None, stretch, gauge) or self.embedded(
                        y, None, stretch, gauge
                    ):
                        yield start
                else:
                    yield from self._shallow(placed)

    def _shallow(self, placed: Placed | None) -> Iterator[Candidate]:
        """Yield a layout, layouts around other holes, and last the map itself if most of it folds."""
        maps = layouts(self.mesh, placed, self._system, self.plan.holes)
        itself = [self.x] if self.plan.embeds and not self.plan.itself else []
        for y, after in unfolded_first(self.mesh, chain(maps, itself)):
            if start := self.record("angles", y) or self.embedded(y, after):
                yield start

    def embedded(
        self,
        x: FloatArray,
        after: FloatArray | None = None,
        stretch: float = 1.0,
        gauge: str = "centred",
    ) -> Candidate | None:
        """A map repaired locally, given what small moves make of it, if that is known; None unless the plan embeds."""
        if self.plan.embeds:
            with self.attempt("embedding"):
                y, certificate = repair_locally(self.mesh, x, after=after)
                return self.record("embedding", y, certificate, stretch, gauge)
        return None

    def steps(self, start: Candidate, least_gain: float, rough: bool = False) -> Candidate:
        """A candidate after a round of steps, or itself if they make it no better."""
        with self.attempt("newton"):
            deep = start.gauge == "poles" or start.stretch > 1
            centred = not (deep or is_off_centre(self.mesh, start.x))
            centroid = np.zeros(3) if centred else weighted_sum(self.mesh.A, start.x)
            x, further = match_angles(
                self.mesh,
                start.x,
                centroid,
                self._system,
                self.effort.systems,
                least_gain,
                damping=DAMPED if deep else HALF_DIGITS,
                rough=rough,
            )
            after = self.record("newton", x, None, start.stretch, start.gauge)
            if after and after.mean < start.mean:
                return replace(after, further=further)
        return start

    def record(
        self,
        name: str,
        x: FloatArray,
        certificate: Certificate | None = None,
        stretch: float = 1.0,
        gauge: str = "centred",
    ) -> Candidate | None:
        """Record a map; a candidate if it is certified. Angles are measured where more than one may follow."""
        if certificate is None:
            certificate = Certificate.of(x, self.mesh.f)
        mean = np.nan
        if self.plan.compares:
            mean = mean_angle_difference(self.mesh, x)
        before = self.rounds[-1].foldings_after if self.rounds else certificate.foldings
        k, now, energy = (
            len(self.rounds),
            time.perf_counter(),
            HarmonicEnergy(self.operators.L).evaluate(x)[0],
        )
        self.rounds.append(
            Round(
                k,
                name,
                before,
                certificate.foldings,
                0,
                energy,
                mean,
                Status.DONE,
                now - self._began,
            )
        )
        self._began = now
        try:
            if self.listener is not None:
                self.listener(Iterate("repair", k, 0, x, energy, float(certificate.foldings)))
        except Exception as error:
            raise OfListener(error) from None
        return Candidate(x, mean, stretch, gauge) if certificate.folding_free else None

    def gauged(self, best: Candidate) -> tuple[FloatArray, Certificate]:
        """A candidate's map in its gauge, and its certificate."""
        if best.gauge == "centred":
            with self.attempt("gauge"):
                return restore_gauge(self.mesh, best.x)
        return best.x, Certificate.of(best.x, self.mesh.f)

    def result(self, field: list[Candidate]) -> tuple[FloatArray, Certificate, Run]:
        """The best candidate that is left in the package's gauge, or the first map, with the record."""
        x, certificate, run = self.x, self.certificate, self.run
        best = min(field, key=attrgetter("mean"), default=None)
        if best is not None and best.x is not x:
            x, certificate = self.gauged(best)
            energy = HarmonicEnergy(self.operators.L).evaluate(x)[0]
            run = replace(run, energy=energy, stretch=best.stretch, gauge=best.gauge)
        rounds = tuple(self.rounds) if len(self.rounds) > 1 else ()
        return x, certificate, replace(run, rounds=rounds, notes=(*run.notes, *self.notes))


def left_out(name: str, error: Exception) -> str:
    """The note on a step that failed; tests raise the error in its place."""
    return f"the step {name} failed and was left out, please report it: {one_line(error)}"
