"""Algorithm 2: foldings are removed by weighted Laplace-Beltrami eigen-projection."""

from __future__ import annotations

from ..errors import FactorisationFailed
from ..mesh.arrays import FloatArray
from ..result.run import Iterate, Round, Run, Stage, Status
from .algorithm_1 import algorithm_1
from .hooks import nonzero
from .setup import Setup


def algorithm_2(setup: Setup, start: Iterate) -> tuple[FloatArray, Run]:
    """Alternate Algorithm 1 and the star map until no folding is left; the map is that of the last round."""
    notes, rounds = setup.notes, []
    for k in range(setup.options.rounds + 1):
        last, record = algorithm_1(setup, start)  # Algorithm 2, steps 1 and 4
        rounds.append(record)
        is_free, is_stopped = record.foldings_after == 0, record.status is Status.STOPPED
        if is_free or is_stopped or k == setup.options.rounds:
            break
        try:
            start = star_map(setup, last, record)
        except FactorisationFailed:
            notes = (
                *notes,
                f"there is no star map for round {k + 1}, as of a map that has shrunk to a point, or of a "
                "flat surface; the default method maps the surface",
            )
            break
    return last.x, Run(record.status, last.energy, rounds=tuple(rounds), notes=notes)


def star_map(setup: Setup, last: Iterate, record: Round) -> Iterate:
    """The next round's start: the star map of the eigenfunctions weighted by the last map's conformal factor."""
    collapsed = record.status is Status.COLLAPSED
    found = setup.hooks.project(setup.mesh, setup.L, last.x, collapsed)  # Algorithm 2, step 2
    return setup.start(  # Algorithm 2, step 3
        Stage.STAR_MAP,
        found.star_map,
        record.round + 1,
        details={"phi": found.phi, "eigenvalues": found.eigenvalues},
        safeguards=nonzero(floored=found.floored, undirected=found.undirected),
    )
