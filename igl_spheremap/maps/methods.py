"""The methods of `spherical_conformal_map`, each a function of a checked mesh and the record of its options."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from ..angles.plan import Large, plan_repair
from ..angles.repair import repair
from ..descent.energies import HarmonicEnergy
from ..descent.gu_yau import projected_descent
from ..descent.minimize import minimize_round
from ..descent.preconditioned import harmonic_map
from ..descent.problem import Problem, l2_metric, laplacian_metric
from ..errors import MapError, Remedy
from ..mesh.arrays import FloatArray, check_directions
from ..mesh.check import Mesh
from ..mesh.measure import corner_angles, vertex_normals
from ..operators.laplacian import Operators, build_operators, laplacian
from ..paper.algorithm_2 import algorithm_2
from ..paper.settings import Lai2014, PaperGauge
from ..paper.setup import Setup
from ..result.run import Iterate, Listener, Round, Run, Stage, Status, iterations_in
from ..sphere.moebius import center, fix_gauge
from ..sphere.rows import unit_rows
from ..start.punctured import candidate_faces, dipole_map, to_sphere
from ..untangle.embedding import fix_orientation
from ..untangle.local_repair import are_few, is_off_centre
from ..verify.certificate import Certificate
from .options import Auto, GuYau, Method, Stereographic
from .repair_last import repair_last
from .safeguards import Safeguards
from .sphere_map import SphereMap


def auto(
    mesh: Mesh,
    options: Auto,
    listener: Listener | None = None,
    operators: Operators | None = None,
    large: Large = "embedded",
) -> SphereMap:
    """The default: one factorisation, a start by two solves, one or two steps, and repair of folds.

    The map is certified free of foldings, unless a listener stopped it, or `large` leaves foldings in place.
    """
    if operators is None:
        operators = build_operators(mesh, options.backend)
    last, status = harmonic_map(
        mesh,
        operators,
        tolerance=options.tolerance,
        max_iterations=options.max_iterations,
        listener=listener,
    )
    x = fix_gauge(mesh, last.x)
    certificate = Certificate.of(x, mesh.f)
    run = Run(status, last.energy, backend=operators.factor.backend, notes=operators.notes)
    if status is Status.STOPPED:
        return SphereMap(mesh, x, certificate, run)
    if 2 * certificate.foldings > len(mesh.f):
        x = fix_orientation(x, mesh.f)
        certificate = Certificate.of(x, mesh.f)
    plan = plan_repair(mesh, x, run.energy, certificate, options.polish, options.effort, large)
    try:
        if plan.starts:
            x, certificate, run = repair(
                mesh,
                x,
                certificate,
                run,
                plan,
                operators,
                listener,
                centred=options.gauge == "centred",
                effort=options.effort,
            )
        elif listener is not None:
            listener(Iterate(Stage.REPAIR, 0, 0, x, run.energy, 0.0))
    except StopIteration:
        return SphereMap(mesh, x, certificate, replace(run, status=Status.STOPPED))
    notes = [*run.notes, *_remarks(mesh, x, run)]
    if plan.layouts:
        notes += _far_from_conformal(mesh, x)
    run = replace(run, notes=tuple(notes), plan=str(plan))
    return SphereMap(mesh, x, certificate, run)


def _remarks(mesh: Mesh, x: FloatArray, run: Run) -> Iterator[str]:
    """Notes on unusual features of a map."""
    if run.gauge == "centred" and is_off_centre(mesh, x):
        yield "not Moebius-centred, which would fold huge faces or spoil their angles"
    elif run.gauge == "poles":
        yield "not Moebius-centred: tips of limbs too deep for float64 are at ends of the axes"
    if run.stretch > 1:
        yield f"limbs too deep for float64 are mapped as if up to {run.stretch:.3g} times shorter"


def _far_from_conformal(mesh: Mesh, x: FloatArray) -> Iterator[str]:
    """A note on a map that is far from conformal on a mesh with thin faces, some of an angle below a degree."""
    difference = np.degrees(corner_angles(x, mesh.f) - mesh.angles)
    off = _angles_off(mesh, difference)
    thin = np.degrees(mesh.angles.min(axis=1)) < 1
    if off is not None and thin.any():
        size = np.where(thin, np.abs(difference).sum(axis=1), -1.0)
        x0, y0, z0 = mesh.v[mesh.f[size.argmax()]].mean(axis=0)
        yield (
            f"{off}: {thin.sum():,} of {len(mesh.f):,} faces have an angle below 1 degree, the worst around "
            f"({x0:.3g}, {y0:.3g}, {z0:.3g}); remesh the surface to even faces, and it maps nearer"
        )


def _angles_off(mesh: Mesh, difference: FloatArray, far: float = 10.0) -> str | None:
    """A map's distance from conformal, by its differences in degrees; None if the mesh explains all but `far`.

    The sum of the differences at a vertex is its curvature less that of its image: if faces are small on the sphere,
    no map can lower it, so it is the mesh's own share.
    """
    at_vertices = np.bincount(mesh.f.ravel(), difference.ravel(), len(mesh.v))
    mean = np.abs(difference).mean()
    explained = np.abs(at_vertices).sum() / difference.size
    if mean - explained <= far:
        return None
    return f"angles are {mean:.3g} degrees off in the mean, of which the mesh's corners explain {explained:.2g}"


def lai2014(
    mesh: Mesh,
    options: Lai2014,
    listener: Listener,
    start: ArrayLike | None = None,
) -> SphereMap:
    """The paper: Algorithm 2 around Algorithm 1, from the Gauss map or another start."""
    setup, first = paper_setup(mesh, options, listener, start)
    x, run = algorithm_2(setup, first)
    last = run.rounds[-1]
    is_free, is_stopped = last.foldings_after == 0, run.status is Status.STOPPED
    if is_free or is_stopped or options.may_fold or options.rounds == 0:
        found = in_gauge(mesh, x, run, options.gauge)
    else:
        found = repair_last(mesh, x, run, setup.problem.energy, options.gauge)
        k, energy = found.run.rounds[-1].round, found.run.energy
        listener(Iterate(Stage.REPAIR, k, 0, found.sphere, energy))
    if options.may_fold or is_stopped:
        return found
    notes = (*found.run.notes, *_shortcomings(mesh, found.sphere, last))
    return replace(found, run=replace(found.run, notes=notes))


def _shortcomings(mesh: Mesh, x: FloatArray, last: Round) -> Iterator[str]:
    """Notes on a correction that took few steps or none, and on a map that is far from conformal."""
    ends_early = last.status is Status.STALLED or last.iterations == 0
    if last.start == Stage.STAR_MAP and ends_early and are_few(last.foldings_after, mesh.f):
        yield (
            f"the map is the star map after {iterations_in(last.iterations)}: further steps fold faces, or lead away "
            "from the mesh's angles"
        )
    off = _angles_off(mesh, np.degrees(corner_angles(x, mesh.f) - mesh.angles))
    if off is not None:
        yield f"{off}; the default method may map it nearer"


def paper_setup(
    mesh: Mesh, options: Lai2014, listener: Listener, start: ArrayLike | None
) -> tuple[Setup, Iterate]:
    """The paper's problem on a mesh, with the safeguards that the options ask for, and the map that starts."""
    setup = Setup.of(mesh, options, listener)
    if setup.problem.fixes_gauge or not options.may_fold:
        setup = replace(setup, hooks=Safeguards(mesh, setup.problem, options.may_fold))
    if start is None:
        return setup, setup.gauss_map()
    return setup, setup.start(Stage.GIVEN_MAP, check_start(start, len(mesh.v)))


def gu_yau(mesh: Mesh, options: GuYau, listener: Listener) -> SphereMap:
    """The baseline that the paper compares with: Gu and Yau's descent, from the Gauss map, by way of the Tutte map."""
    energy = HarmonicEnergy.of(mesh)
    L2 = l2_metric(mesh)
    rounds: list[Round] = []

    def descend(
        name: str, x: FloatArray, stage: Stage, L: sp.csr_matrix, plateau: float
    ) -> FloatArray:
        problem = Problem.of(mesh, HarmonicEnergy(L), laplacian_metric(L))
        last, record = minimize_round(
            mesh,
            name,
            x,
            projected_descent(problem, L2, x, options.step),
            stage,
            round=len(rounds),
            tolerance=options.gradient_tolerance,
            plateau=plateau,
            max_iterations=options.max_iterations,
            listener=listener,
        )
        rounds.append(record)
        return last.x

    name, x = "gauss map", vertex_normals(mesh.unit, mesh.f)
    if options.tutte:
        L = laplacian(mesh.unit, mesh.f, "uniform", mesh.edges)
        x = descend(name, x, Stage.TUTTE, L, options.tutte_plateau)
        name = "tutte map"
    if not rounds or rounds[-1].status is not Status.STOPPED:
        x = descend(name, x, Stage.ALGORITHM_1, energy.L, options.plateau)
    return in_gauge(mesh, x, Run(rounds[-1].status, energy.evaluate(x)[0], rounds=tuple(rounds)))


def stereographic(mesh: Mesh, options: Stereographic, listener: Listener) -> SphereMap:
    """The punctured-plane baseline: a conformal map to the plane, then inverse stereographic projection.

    A note names the face: of several candidates that whose map has the least energy.
    """
    operators = build_operators(mesh, options.backend)
    harmonic = HarmonicEnergy(operators.L)
    faces = candidate_faces(mesh)
    if options.puncture is not None:
        faces = iter([_checked_face(mesh, options.puncture)])
    tried = []
    for each in faces:
        z = dipole_map(mesh, operators, each)
        if np.isfinite(z).all():
            y = center(np.ascontiguousarray(to_sphere(z, mesh.A)), mesh.A)
            tried.append((harmonic.evaluate(y)[0], each, y))
    if not tried:
        raise MapError("the plane map is not finite; puncture another face")
    energy, face, x = min(tried, key=lambda each: each[:2])
    status = Status.DONE
    try:
        listener(Iterate(Stage.STEREOGRAPHIC, 0, 1, x, energy))
    except StopIteration:
        status = Status.STOPPED
    notes = (*operators.notes, f"face {face} is punctured")
    return in_gauge(mesh, x, Run(status, energy, backend=operators.factor.backend, notes=notes))


def _checked_face(mesh: Mesh, face: int) -> int:
    """The face; an error if the mesh has none of that number."""
    if face not in range(len(mesh.f)):
        raise ValueError(
            f"there is no face {face} to puncture; give one of the faces 0 to {len(mesh.f) - 1}"
        )
    return int(face)


#: The function that maps a mesh by a method, by the class of the method's options.
SOLVERS: dict[type[Method], Callable[..., SphereMap]] = {
    Auto: auto,
    Lai2014: lai2014,
    GuYau: gu_yau,
    Stereographic: stereographic,
}


def in_gauge(mesh: Mesh, x: FloatArray, run: Run, gauge: PaperGauge = "centred") -> SphereMap:
    """The map in the gauge of the result, certified; if the gauge is free or folds it, as minimised."""
    y, notes = x, run.notes
    if gauge == "centred":
        y = fix_gauge(mesh, x)
    certificate = Certificate.of(y, mesh.f)
    if y is not x and not certificate.folding_free:
        before = Certificate.of(x, mesh.f)
        if before.folding_free:
            y, certificate, gauge = x, before, "free"
            notes = (*notes, "not in the gauge: the rounding of the last rotation would fold faces")
    if not certificate.folding_free:
        mended = Remedy("repair_foldings", given="v, f, sphere")
        notes = (*notes, f"foldings are left; {mended} removes them, as the default method does")
    if gauge == "free":
        run = replace(run, gauge="free")
    return SphereMap(mesh, y, certificate, replace(run, notes=notes))


def check_start(x: ArrayLike, n: int, name: str = "start positions") -> FloatArray:
    """Rows scaled to unit length; a MeshError if one of `n` is missing, zero or not finite."""
    return unit_rows(check_directions(x, n, name))  # eq. (4)
