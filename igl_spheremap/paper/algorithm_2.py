"""Algorithm 2: foldings are removed by weighted Laplace-Beltrami eigen-projection."""

from __future__ import annotations

from ..errors import FactorisationFailed
from ..mesh.arrays import FloatArray
from ..result.run import Iterate, Run, Stage, Status
from .algorithm_1 import algorithm_1
from .hooks import nonzero
from .setup import Setup
from .star_map import project, project_unweighted


def algorithm_2(setup: Setup, start: Iterate) -> tuple[FloatArray, Run]:
    """Alternate Algorithm 1 and the star map until no folding is left; the map is that of the last round."""
    notes, rounds = setup.notes, []
    for k in range(setup.options.rounds + 1):
        last, record = algorithm_1(setup, start)  # Algorithm 2, steps 1 and 4
        rounds.append(record)
        if k == setup.options.rounds or record.status is Status.STOPPED:
            break
        if not setup.hooks.goes_on(record):
            break
        try:
            start = star_map(setup, last, k + 1, setup.hooks.restarts(record))
        except FactorisationFailed:
            notes = (
                *notes,
                f"there is no star map for round {k + 1}, as of a map that has shrunk to a point, or of a "
                "flat surface; the default method maps the surface",
            )
            break
    return last.x, Run(record.status, last.energy, rounds=tuple(rounds), notes=notes)


def star_map(setup: Setup, last: Iterate, round: int, restarts: bool) -> Iterate:
    """The next round's start: the star map of the eigenfunctions weighted by the last map's conformal factor.

    If the run `restarts`, it is the star map of unweighted eigenfunctions, projected again.
    """
    if restarts:
        found = project_unweighted(setup.mesh, setup.L, last.x, setup.problem.centred)
    else:
        found = project(setup.mesh, setup.L, last.x)  # Algorithm 2, step 2
    return setup.start(  # Algorithm 2, step 3
        Stage.STAR_MAP,
        found.star_map,
        round,
        details={"phi": found.phi, "eigenvalues": found.eigenvalues},
        safeguards=nonzero(floored=found.floored, undirected=found.undirected),
    )
