"""The loop around every first-order solver: it draws iterates, notifies a listener, and decides when to end."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from ..mesh.check import Mesh
from ..result.run import Iterate, Listener, Round, Status
from ..verify.certificate import Certificate
from ..verify.distortion import mean_angle_difference

#: Steps over which a plateau is judged: Barzilai-Borwein energies oscillate with periods of tens.
_WINDOW = 100


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where a minimisation ended, and why there."""

    last: Iterate
    status: Status
    #: Wall time.
    seconds: float

    def as_round(self, mesh: Mesh, start: Iterate) -> Round:
        """The record of a minimisation from `start`, with foldings before and after; of degree 0 the map collapsed."""
        before, after = (
            Certificate.of(start.x, mesh.f).foldings,
            Certificate.of(self.last.x, mesh.f),
        )
        collapsed = after.degree == 0 and self.status is not Status.STOPPED
        return Round(
            start.round,
            start.stage,
            before,
            after.foldings,
            self.last.iteration,
            self.last.energy,
            mean_angle_difference(mesh, self.last.x),
            Status.COLLAPSED if collapsed else self.status,
            self.seconds,
        )


def minimize(
    iterates: Iterator[Iterate],
    *,
    tolerance: float,
    max_iterations: int,
    plateau: float = 0.0,
    settled: Callable[[Iterate], bool] | None = None,
    listener: Listener | None = None,
    round: int = 0,
) -> Minimum:
    """Run a solver until its residual is at most the tolerance, Algorithm 1, step 2.

    The solver yields its start, then every iterate, and ends where no step is acceptable; what the residual is depends
    on the solver. The run has also converged when `settled`, a rule of its own, is true of an iterate. It ends at a
    plateau when the lowest energy fell by less than the share `plateau` over the last 100 steps; 0 switches this rule
    off. A listener may raise StopIteration. `round` is stamped on the iterates.
    """
    energies: list[float] = []
    began = time.perf_counter()
    status = Status.STALLED
    for iterate in iterates:
        last = replace(iterate, round=round)
        energies.append(last.energy)
        try:
            if listener is not None:
                listener(last)
        except StopIteration:
            status = Status.STOPPED
            break
        # Algorithm 1, step 2
        if last.residual <= tolerance or (settled is not None and settled(last)):
            status = Status.CONVERGED
            break
        if _is_flat(energies, plateau):
            status = Status.PLATEAU
            break
        if last.iteration >= max_iterations:
            status = Status.MAX_ITERATIONS
            break
    return Minimum(last, status, time.perf_counter() - began)


def _is_flat(energies: list[float], plateau: float) -> bool:
    """True if the lowest energy fell by less than the share `plateau` of it over the last 100 steps."""
    if plateau == 0 or len(energies) % _WINDOW or len(energies) <= _WINDOW:
        return False
    lowest = min(energies)
    return min(energies[:-_WINDOW]) - lowest < plateau * lowest
