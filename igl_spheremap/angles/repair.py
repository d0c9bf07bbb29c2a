"""The repair: from a map with foldings to one that is certified to have none, near the mesh's angles.

A plan (plan.py) lets a map stay as it is, or says which maps start; they race (race.py):

1. *map*: the map itself, if at most 1 percent of its faces fold.
2. *angles*: the body laid out in the plane by closing angles, which can't underflow, and put on the sphere: if limbs
   are too deep for float64, in one way (poles.py), else around several holes (candidates.py).
3. *embedding*: folded maps are repaired by small moves, or else by progressive embedding, before they start; layouts
   that small moves don't repair start after the others, and a map that mostly folds starts last.
4. *newton*: damped Newton steps lower the angle differences of the whole map (effort.py limits their cost).

Only a certified map enters or replaces another one. A step that fails leaves the map as it is, and a note.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import islice
from operator import attrgetter

import numpy as np

from ..descent.energies import HarmonicEnergy
from ..errors import FactorisationFailed, MapError, MeshError, OfListener, one_line
from ..mesh.arrays import HALF_DIGITS, FloatArray
from ..mesh.check import Mesh
from ..newton.loop import DAMPED
from ..newton.system import VertexSystem
from ..operators.laplacian import Operators
from ..result.run import Iterate, Listener, Round, Run, Stage, Status
from ..sphere.rows import weighted_sum
from ..timings import phase
from ..untangle.local_repair import is_off_centre, repair_locally, restore_gauge
from ..verify.certificate import Certificate
from ..verify.distortion import mean_angle_difference
from .candidates import Start, from_the_best, layouts
from .effort import Effort
from .layout import unroll
from .match_angles import match_angles
from .plan import POOR, Plan
from .poles import is_too_deep, map_deep_limbs
from .race import Candidate, race

#: Errors of a step for want of arithmetic or memory. All others, such as a caller's time limit, end the call.
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
    work = _Repair(mesh, x, certificate, run.energy, plan, operators, listener, centred, effort)
    best = None
    try:
        with work.attempt("repair"):
            field = work.candidates()
            best = min(field, key=attrgetter("mean"), default=None)
            if best is not None and np.isfinite(plan.price):
                best = race(field, partial(work.improve, least_gain=plan.price), plan.price)
        return work.finish(best, run)
    except OfListener as raised:
        if isinstance(raised.error, StopIteration):
            raise raised.error from None
        raise


@dataclass
class _Repair:
    """Carries out a plan, and records it."""

    mesh: Mesh
    x: FloatArray
    certificate: Certificate
    energy: float
    plan: Plan
    operators: Operators
    listener: Listener | None
    centred: bool
    effort: Effort

    def __post_init__(self) -> None:
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
        """Take a step; if it fails, leave the map as it is, and a note."""
        try:
            yield
        except _FAILURES as error:
            self.notes.append(left_out(name, error))

    def candidates(self, rough_gain: float = 0.1) -> list[Candidate]:
        """All candidates. If there may be several, each first takes rough steps, whose gains predict nothing."""
        field = list[Candidate]()
        certified = filter(None, map(self.certify_or_embed, self.starts()))
        for candidate in islice(certified, self.plan.starts):
            if self.plan.starts > 1:
                rough = self.improve(candidate, rough_gain, rough=True)
                candidate = replace(rough, further=np.inf)
            field.append(candidate)
            if candidate.mean <= POOR:
                break
        if not field:
            last = self.embed(Start("embedding", self.x, certificate=self.certificate))
            if last is not None:
                field = [last]
        return field

    def starts(self) -> Iterator[Start]:
        """Yield the maps that may start, in order, each made on demand."""
        itself = Start("map", self.x, certificate=self.certificate)
        if self.plan.use_map:
            yield itself
        else:
            self.certify(itself)
        if self.plan.layouts:
            with self.attempt("angles"):
                placed = unroll(self.mesh, self.x, self._system)
                if is_too_deep(placed):
                    yield map_deep_limbs(placed, self.mesh.angles, self.centred)
                else:
                    made = layouts(self.mesh, placed, self._system, self.plan.holes)
                    yield from from_the_best(self.mesh, made)
                    if self.plan.embeds and not self.plan.use_map:
                        yield from from_the_best(self.mesh, [Start("angles", self.x)])

    def certify_or_embed(self, start: Start) -> Candidate | None:
        """The map as it is if no face folds, else repaired."""
        candidate = self.certify(start)
        if candidate is None:
            candidate = self.embed(start)
        return candidate

    def embed(self, start: Start) -> Candidate | None:
        """Repair a map locally; None if the plan forbids embedding, or it fails."""
        if self.plan.embeds:
            with self.attempt("embedding"):
                before = start.certificate
                if before is None:
                    before = Certificate.of(start.x, self.mesh.f)
                y, certificate = repair_locally(self.mesh, start.x, before, after=start.after_moves)
                done = replace(start, name="embedding", x=y, certificate=certificate)
                return self.certify(done)
        return None

    def improve(self, before: Candidate, least_gain: float, rough: bool = False) -> Candidate:
        """A candidate after a round of steps; if they make it no better, itself."""
        with self.attempt("newton"):
            deep = before.gauge == "poles" or before.stretch > 1
            centroid, damping = weighted_sum(self.mesh.A, before.x), DAMPED
            if not deep:
                damping = HALF_DIGITS
                if not is_off_centre(self.mesh, before.x):
                    centroid = np.zeros(3)
            x, further = match_angles(
                self.mesh,
                before.x,
                centroid,
                self._system,
                self.effort.systems,
                least_gain,
                damping=damping,
                rough=rough,
            )
            start = Start("newton", x, stretch=before.stretch, gauge=before.gauge)
            after = self.certify(start)
            if after is not None and after.mean < before.mean:
                return replace(after, further=further)
        return before

    def certify(self, start: Start) -> Candidate | None:
        """Record a map; if it is certified, return a candidate. If more than one may follow, angles are measured."""
        x, k, now = start.x, len(self.rounds), time.perf_counter()
        certificate, mean = start.certificate, np.nan
        if certificate is None:
            certificate = Certificate.of(x, self.mesh.f)
        if self.plan.compares:
            mean = mean_angle_difference(self.mesh, x)
        energy = self.energy
        if x is not self.x:
            energy = HarmonicEnergy(self.operators.L).evaluate(x)[0]
        foldings = certificate.foldings
        before = foldings
        if self.rounds:
            before = self.rounds[-1].foldings_after
        self.rounds.append(
            Round(
                round=k,
                start=start.name,
                foldings_before=before,
                foldings_after=foldings,
                iterations=0,
                energy=energy,
                mean_angle_difference=mean,
                status=Status.DONE,
                seconds=now - self._began,
            )
        )
        self._began = now
        if self.listener is not None:
            try:
                self.listener(Iterate(Stage.REPAIR, k, 0, x, energy, float(foldings)))
            except Exception as error:
                raise OfListener(error) from None
        if not certificate.folding_free:
            return None
        return Candidate(x, mean, start.stretch, start.gauge)

    def in_gauge(self, best: Candidate) -> tuple[FloatArray, Certificate]:
        """A candidate's map in its gauge, and its certificate."""
        if best.gauge == "centred":
            with self.attempt("gauge"):
                return restore_gauge(self.mesh, best.x)
        return best.x, Certificate.of(best.x, self.mesh.f)

    def finish(self, best: Candidate | None, run: Run) -> tuple[FloatArray, Certificate, Run]:
        """The best candidate in the package's gauge, or the first map if there is none, and the record."""
        x, certificate = self.x, self.certificate
        if best is not None and best.x is not x:
            x, certificate = self.in_gauge(best)
            energy = HarmonicEnergy(self.operators.L).evaluate(x)[0]
            run = replace(run, energy=energy, stretch=best.stretch, gauge=best.gauge)
        rounds = tuple(self.rounds)
        if len(rounds) == 1:  # the map stays as it is
            rounds = ()
        return x, certificate, replace(run, rounds=rounds, notes=(*run.notes, *self.notes))


def left_out(name: str, error: Exception) -> str:
    """The note on a step that failed; tests raise the error in its place."""
    return f"the step {name} failed and was left out, please report it: {one_line(error)}"
