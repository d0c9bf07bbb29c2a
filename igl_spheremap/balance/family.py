"""The family of maps from conformal (balance 0) to area-preserving (balance 1)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from ..angles.deep_limbs import floor_of, shorten_limbs
from ..angles.layout import onto_sphere, unroll
from ..descent.energies import HarmonicEnergy
from ..descent.minimize import State, minimize
from ..mesh.arrays import EPS, FloatArray
from ..mesh.check import Mesh
from ..mesh.measure import FLOAT64_LIMIT, log_edges
from ..newton.faces import FaceProblem
from ..newton.loop import newton
from ..newton.system import VertexSystem
from ..operators.laplacian import usable_laplacian
from ..result.findings import as_factor
from ..result.run import Iterate, Listener, Run, Stage, Status
from ..sphere.moebius import turn_to_gauss_map
from ..timings import phase
from ..untangle.local_repair import repair_locally
from ..verify.certificate import Certificate
from .energy import BalancedEnergy
from .flat_faces import FlatFaces, log_areas
from .kept_factor import KeptFactor

#: Weight of the areas at most: at 1 nothing would hold the angles.
MOST_WEIGHT = 0.97
#: k of the final energy: 1 is polyconvex, .9 up to s1 = 5 s2, and ends lower.
POWER = 0.9


def balanced_map(
    mesh: Mesh,
    conformal: FloatArray,
    x: FloatArray,
    balance: float,
    listener: Listener | None = None,
    backend: str = "auto",
    most_off: float = 0.3,
) -> tuple[FloatArray, Certificate, Run]:
    """The map of a balance from a map x without foldings, and how the minimisation ended.

    `conformal` is the conformal map of the mesh. The result is turned to the Gauss map. If its image areas are off by
    more than `most_off` on average, in logarithms, it is short.
    """
    source = FlatFaces.of(mesh.unit, mesh.f)
    energy = balanced_energy(source, conformal, balance)
    with phase("balance"):
        last, status = minimize_balanced(
            partial(FaceProblem, turns=False),
            VertexSystem(source.f, source.n, backend),
            energy,
            stretched(mesh, x, backend),
            listener,
        )
    off, notes = energy.area_error(last.x), tuple[str, ...]()
    if off > most_off and status is not Status.STOPPED:
        notes = (
            f"areas are off what balance {balance:g} aims at by a factor of {as_factor(off)} on average; "
            f"{status.value}",
        )
        status = Status.SHORT
    y = turn_to_gauss_map(mesh, last.x)
    certificate = Certificate.of(y, mesh.f)
    if not certificate.folding_free:  # by the rounding of the rotation
        y, certificate = last.x, Certificate.of(last.x, mesh.f)
    harmonic = HarmonicEnergy(usable_laplacian(mesh)).evaluate(y)[0]
    return y, certificate, Run(status, harmonic, notes=notes, gauge="turned")


def balanced_energy(source: FlatFaces, conformal: FloatArray, balance: float) -> BalancedEnergy:
    """The energy of a balance, docs/balance.md (3) and (10), for a conformal map without foldings."""
    area, factor = source.area, log_factor(source, conformal)
    target = (1 - balance) * factor
    target -= np.log((area * np.exp(target)).sum() / (area * np.exp(factor)).sum())  # balance (10)
    return BalancedEnergy(source, min(balance, MOST_WEIGHT), POWER, target)


def minimize_balanced(
    problem: Callable[[BalancedEnergy], FaceProblem],
    system: VertexSystem,
    energy: BalancedEnergy,
    x: FloatArray,
    listener: Listener | None = None,
    *,
    tolerance: float = 0.005,
    far: float = 1.05,
    rough: float = 0.1,
    steps: int = 80,
) -> tuple[Iterate, Status]:
    """Minimise from a map free of foldings; if its areas are far off, by squares of logarithms first.

    `problem` gives the surface on which maps of an energy lie, and further conditions. The last step gains the share
    `tolerance` of the energy. Areas are far off if the energy is `far` times that of squares. In this opening areas
    count no more than angles, and a rough minimum is enough.
    """
    search, squares, left = KeptFactor(system, tolerance), replace(energy, power=0), steps

    def minimum(
        energy: BalancedEnergy, stage: Stage, tolerance: float, most: int
    ) -> tuple[Iterate, Status]:
        search.tolerance = tolerance
        return minimize(
            balanced_iterates(problem(energy), search, x),
            stage,
            tolerance=tolerance,
            max_iterations=most,
            listener=listener,
        )

    if energy.by_face(x).sum() > far * squares.by_face(x).sum():
        opening = replace(squares, weight=min(energy.weight, 0.5))
        opened, status = minimum(opening, Stage.OPENING, rough, steps // 2)
        if status is Status.STOPPED:
            return opened, status
        x, left = opened.x, steps - opened.iteration
    return minimum(energy, Stage.BALANCE, tolerance, left)


def balanced_iterates(problem: FaceProblem, search: KeptFactor, x: FloatArray) -> Iterator[State]:
    """Newton iterates from a map free of foldings; the residual is the share of the energy still to gain.

    After a full step that is the geometric series of the last two gains, whose ratio counts as .9 at most; after a
    shortened one the largest of the last three; after one with an old factor its predicted gain.
    """
    value, gains, residual = problem.value(x), [1.0] * 3, np.inf
    zero = EPS * problem.energy.area.sum()
    if value < zero:
        residual = 0.0
    yield State(0, x, value, residual)
    for k, trial in enumerate(newton(problem, search, x), 1):
        gains.append((value - trial.value) / max(trial.value, zero))
        value, residual = trial.value, max(gains[-3:])
        if search.length == 1:
            ratio = min(gains[-1] / gains[-2], 0.9)
            residual = gains[-1] * ratio / (1 - ratio)
        residual = min(residual, search.ahead)
        if value < zero:
            residual = 0.0
        yield State(k, trial.x, value, residual, search.length)


def stretched(mesh: Mesh, x: FloatArray, backend: str) -> FloatArray:
    """The map, or, if its shortest edges are as small as rounding, one laid out anew with room for limbs.

    Newton steps can't move faces whose images are as small as rounding. Limbs get the room that float32 needs: half of
    float64's digits are left to move them.
    """
    if log_edges(x, mesh.f).min() > np.log(FLOAT64_LIMIT):
        return x
    laid_out = unroll(mesh, x, VertexSystem(mesh.f, len(x), backend, limbs=True))
    if laid_out is None:
        return x
    points, _ = shorten_limbs(laid_out, mesh.angles, floor_of(np.float32))
    y = onto_sphere(laid_out, points)
    certificate = Certificate.of(y, mesh.f)
    if certificate.folding_free:
        return y
    return repair_locally(mesh, y, certificate)[0]


def log_factor(source: FlatFaces, x: FloatArray, averages: int = 2) -> FloatArray:
    """Logarithm of image area over source area by face, averaged over neighbours, which takes out noise of faces."""
    value = log_areas(source, x)
    corners, share = source.f.ravel(), np.repeat(source.area, 3)
    around = np.bincount(corners, share, source.n)
    for _ in range(averages):
        at_vertices = np.bincount(corners, share * np.repeat(value, 3), source.n) / around
        value = at_vertices[source.f].mean(axis=1)  # balance (9)
    return value
