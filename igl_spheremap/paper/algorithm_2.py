"""Algorithm 2: foldings are removed by weighted Laplace-Beltrami eigen-projection."""

from __future__ import annotations

from ..errors import FactorisationFailed
from ..mesh.arrays import FloatArray
from ..result.run import Iterate, Run, Status
from .algorithm_1 import algorithm_1
from .safeguards import nonzero
from .setup import Setup
from .star_map import project


def algorithm_2(setup: Setup, start: Iterate) -> tuple[FloatArray, Run]:
    """Alternate Algorithm 1 and the star map until no folding is left.

    The map is that of the last round, or, to `keep_best`, of the last among those that left the fewest foldings.
    """
    options, notes = setup.options, setup.notes
    done = []
    for k in range(options.rounds + 1):
        minimum, record = algorithm_1(setup, start)  # Algorithm 2, steps 1 and 4
        done.append((minimum.last, record))
        if record.foldings_after == 0 or k == options.rounds or minimum.status is Status.STOPPED:
            break
        try:
            start = star_map(setup, minimum.last, k + 1)
        except FactorisationFailed as error:  # of surfaces without normals, such as flat ones
            notes = (*notes, f"foldings were removed in {k} rounds only: there is no star map ({error})")
            break
    last, record = done[-1]
    if options.keep_best:
        last, record = min(reversed(done), key=lambda each: each[1].foldings_after)
        if record.round < done[-1][1].round:
            notes = (*notes, f"the map is that of round {record.round}: later rounds left more foldings")
    status = Status.STOPPED if minimum.status is Status.STOPPED else record.status
    return last.x, Run(status, last.energy, rounds=tuple(record for _, record in done), notes=notes)


def star_map(setup: Setup, last: Iterate, round: int) -> Iterate:
    """The start of a round: the star map of the eigenfunctions that the map of the last round weights."""
    found = project(setup.mesh, setup.L, last.x)  # Algorithm 2, step 2
    return setup.start(  # Algorithm 2, step 3
        "star map", found.star_map, round,
        details={"phi": found.phi, "eigenvalues": found.eigenvalues},
        safeguards=nonzero(floored=found.floored, undirected=found.undirected))
