"""Algorithm 2: foldings are removed by weighted Laplace-Beltrami eigen-projection."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from scipy.sparse import csr_matrix

from ..descent.energies import HarmonicEnergy
from ..descent.minimize import Minimum
from ..descent.problem import Metric, Problem
from ..errors import FactorisationFailed
from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..result.run import Iterate, Listener, Round, Run, Status
from ..start.star_map import project
from ..verify.certificate import Certificate
from .local_repair import has_few_foldings, repair_locally

#: Projections within a round end when the energy of a star map differs from that of the last by less than this share:
#: Algorithm 1, which follows, lowers it by far more.
_SETTLED = 1e-4


def algorithm_2(
    mesh: Mesh,
    energy: HarmonicEnergy,
    x: FloatArray,
    name: str,
    algorithm_1: Callable[[Problem, Iterate], Minimum],
    rounds: int,
    projections: int = 1,
    *,
    metric: Metric | None = None,
    gauge: bool = True,
    repair_star_maps: bool = True,
    keep_best: bool = True,
    listener: Listener | None = None,
) -> tuple[FloatArray, Run]:
    """Alternate Algorithm 1 and up to `rounds` eigen-projections until no folding is left.

    A round has up to `projections` of them, each weighted by the star map of the last, until the energy settles.
    `name` is that of the first map in the record of the run; the listener sees the start of every round. The map is
    that of the last round, or, to `keep_best`, of the last among those that left the fewest foldings.
    """
    problem = Problem.of(mesh, energy, metric, gauge)
    done: list[Round] = []
    notes: tuple[str, ...] = ()
    start = _start(problem, name, 0, x)
    for k in range(rounds + 1):
        began = time.perf_counter()
        # Algorithm 2, steps 1 and 4
        minimum = _stopped_at(start, listener) or algorithm_1(problem, _first(mesh, start, repair_star_maps))
        minimum = minimum.centred(problem)
        done.append(minimum.as_round(mesh, start, time.perf_counter() - began))
        if not keep_best or done[-1].foldings_after <= min(record.foldings_after for record in done):
            best = minimum
        if done[-1].foldings_after == 0 or k == rounds or minimum.status is Status.STOPPED:
            break
        try:
            start = _star_map(mesh, problem, energy.L, minimum.last, k + 1, projections)
        except FactorisationFailed as error:  # of surfaces without normals, such as flat ones
            notes = (f"foldings were removed in {k} rounds only: there is no star map ({error})",)
            break
    if best is not minimum:
        notes = (*notes, f"the map is that of round {best.last.round}: later rounds left more foldings")
    status = Status.STOPPED if minimum.status is Status.STOPPED else best.status
    return best.last.x, Run(status, best.last.energy, rounds=tuple(done), notes=notes)


def _start(problem: Problem, name: str, round: int, x: FloatArray) -> Iterate:
    """The start of a round, in the gauge of the problem."""
    y = problem.centred(x)
    return Iterate(name, round, 0, y, problem.energy.evaluate(y)[0], safeguards=None if y is x else {"centred": 1})


def _star_map(mesh: Mesh, problem: Problem, L: csr_matrix, last: Iterate, round: int, projections: int) -> Iterate:
    """The start of a round: the star map of the eigenfunctions that a map weights, and these in its details."""
    for _ in range(projections):
        projection = project(mesh, L, last.x)  # Algorithm 2, step 2
        before, last = last.energy, _start(problem, "star map", round, projection.star_map)  # Algorithm 2, step 3
        if abs(last.energy - before) < _SETTLED * before:
            break
    return replace(last, details={"phi": projection.phi, "eigenvalues": projection.eigenvalues})


def _first(mesh: Mesh, start: Iterate, repair: bool) -> Iterate:
    """What Algorithm 1 gets: a star map, if asked, repaired where few faces are folded, for only then are none kept."""
    if repair and start.round > 0:
        certificate = Certificate.of(start.x, mesh.f)
        if certificate.foldings and has_few_foldings(certificate, mesh.f):
            return replace(start, x=repair_locally(mesh, start.x), safeguards={"repaired": certificate.foldings})
    return replace(start, safeguards=None)


def _stopped_at(start: Iterate, listener: Listener | None) -> Minimum | None:
    """Notify the listener; if it stops the run, the start is where it ended."""
    try:
        if listener is not None:
            listener(start)
    except StopIteration:
        return Minimum(start, Status.STOPPED)
    return None
