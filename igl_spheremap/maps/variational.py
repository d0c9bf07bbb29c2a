"""Algorithm 1 on the paper's further problems."""

from __future__ import annotations

import time
from typing import Any

from numpy.typing import ArrayLike

from ..descent.algorithm_1 import CayleyBB
from ..descent.energies.harmonic import HarmonicEnergy
from ..descent.minimize import minimize
from ..descent.problem import Problem
from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..result.run import Iterate, Listener
from ..untangle.candidate import Candidate
from ..verify.certificate import certify_checked
from .run import check_start
from .spherical_conformal_map import spherical_conformal_map


def start_of(mesh: Mesh, x0: ArrayLike | None) -> tuple[str, FloatArray]:
    """Name and map to start from: the given one, or the conformal map."""
    if x0 is None:
        return "conformal map", spherical_conformal_map(mesh.vertices, mesh.f).sphere
    return "given map", check_start(x0, len(mesh.v))


def descend(
    mesh: Mesh,
    problem: Problem,
    name: str,
    x: FloatArray,
    keep_injective: bool,
    listener: Listener,
    limits: dict[str, Any],
) -> Candidate:
    """Algorithm 1 on a problem; where its energy fixes the Moebius gauge the map stays as it is."""
    began = time.perf_counter()
    solver = CayleyBB(keep_injective=keep_injective)
    minimum = minimize(solver.iterates(problem, x), listener=listener, **limits)
    y = minimum.last.x
    start = Iterate(name, 0, 0, x, problem.energy.evaluate(x)[0])
    done = minimum.as_round(mesh, start, time.perf_counter() - began)
    energy = HarmonicEnergy.of(mesh).evaluate(y)[0]
    if problem.gauge:
        return Candidate(y, energy, minimum.status, (done,))
    return Candidate(y, energy, minimum.status, (done,), certify_checked(y, mesh.f), gauge="free")
