"""The baseline that the paper compares with: Gu and Yau's descent, from the Gauss map over the Tutte map."""

from __future__ import annotations

import time

import scipy.sparse as sp

from ...descent.energies.harmonic import HarmonicEnergy
from ...descent.gu_yau import ProjectedDescent, step_metric
from ...descent.minimize import Minimum, minimize
from ...descent.problem import Problem, harmonic_problem
from ...mesh.arrays import FloatArray
from ...mesh.check import Mesh
from ...mesh.measure import vertex_normals
from ...operators.laplacian import laplacian, usable_laplacian
from ...result.run import Iterate, Listener, Round, Status
from ...untangle.candidate import Candidate
from ..options import GuYau


def gu_yau(mesh: Mesh, options: GuYau, listener: Listener) -> Candidate:
    """Map a mesh."""
    harmonic = harmonic_problem(mesh)
    rounds: list[Round] = []

    def descend(name: str, x: FloatArray, stage: str, L: sp.csr_matrix, plateau: float) -> Minimum:
        began = time.perf_counter()
        start = Iterate(name, len(rounds), 0, x, harmonic.energy.evaluate(x)[0])
        problem = Problem.of(mesh, HarmonicEnergy(L), step_metric(L))
        minimum = minimize(
            ProjectedDescent(options.step, stage).iterates(problem, x),
            tolerance=options.tolerance,
            plateau=plateau,
            max_iterations=options.max_iterations,
            listener=listener,
            round=len(rounds),
        ).centred(harmonic)
        rounds.append(minimum.as_round(mesh, start, time.perf_counter() - began))
        return minimum

    name, x = "gauss map", vertex_normals(mesh.v, mesh.f)
    if options.tutte:
        minimum = descend(name, x, "tutte", laplacian(mesh.v, mesh.f, "uniform", mesh.edges), options.tutte_plateau)
        name, x = "tutte map", minimum.last.x
    if not options.tutte or minimum.status is not Status.STOPPED:
        minimum = descend(name, x, "harmonic", usable_laplacian(mesh), options.plateau)
    return Candidate(minimum.last.x, minimum.last.energy, minimum.status, tuple(rounds))
