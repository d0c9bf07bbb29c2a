"""What all maps have in common: the checks before, and the way from a candidate to the result."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from numpy.typing import ArrayLike

from ..mesh.arrays import FloatArray, check_directions
from ..mesh.check import Mesh, check_mesh
from ..mesh.timings import timed, timings
from ..result.run import History, Listener
from ..result.sphere_map import SphereMap
from ..sphere.gauge import fix_gauge
from ..sphere.rows import unit_rows
from ..untangle.candidate import Candidate
from ..untangle.local_repair import repair_locally
from ..verify.certificate import certify_checked


def check_start(x: ArrayLike, n: int, name: str = "start positions") -> FloatArray:
    """Rows scaled to unit length; a MeshError if one of `n` is missing, zero or not finite."""
    return unit_rows(check_directions(x, n, name))  # eq. (4)


@timed()
def run(
    v: ArrayLike,
    f: ArrayLike,
    solve: Callable[[Mesh, Listener], Candidate],
    name: str,
    settings: dict[str, Any],
    listener: Listener | None = None,
) -> SphereMap:
    """Check a mesh, map it by `solve`, and certify the map."""
    began = time.perf_counter()
    mesh = check_mesh(v, f)
    history = History(listener)
    return finish(mesh, solve(mesh, history), history, name, settings, began)


def finish(
    mesh: Mesh, found: Candidate, history: History, method: str, settings: dict[str, Any], began: float
) -> SphereMap:
    """Put a candidate into the gauge unless it is there, and certify the very numbers that are returned."""
    x, certificate, notes = found.x, found.certificate, found.notes
    if certificate is None:
        x = fix_gauge(mesh, found.x)
        certificate = certify_checked(x, mesh.f)
        if not certificate.folding_free and certify_checked(found.x, mesh.f).folding_free:
            x = repair_locally(mesh, x)
            certificate = certify_checked(x, mesh.f)
            notes = (*notes, "the rounding of the last rotation folded faces, which were repaired")
    moves = sum(step.iteration > 0 for step in history.steps)
    return SphereMap(mesh.vertices, mesh.f, x, certificate, found.energy, found.status, moves,
                     time.perf_counter() - began, method, tuple(history.steps), found.rounds, found.backend,
                     notes, settings, found.gauge, found.stretch, timings=timings())
