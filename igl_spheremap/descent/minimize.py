"""The loop around every first-order solver: it draws iterates, notifies a listener, and decides when to end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import count

from ..mesh.check import Mesh
from ..result.run import Iterate, Listener, Round, Status
from ..verify.distortion import mean_angle_difference
from ..verify.signs import folded_faces
from .problem import Problem

#: Steps over which a plateau is judged: Barzilai-Borwein energies oscillate with periods of tens.
_WINDOW = 100


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where a minimisation ended, and why there."""

    last: Iterate
    status: Status

    def centred(self, problem: Problem) -> Minimum:
        """In the gauge of the result, unless rounding there folds a face of a map without foldings."""
        x = problem.centred(self.last.x)
        folded, were_folded = (folded_faces(y, problem.f).any() for y in (x, self.last.x))
        if folded and not were_folded:
            return self
        return replace(self, last=replace(self.last, x=x, energy=problem.energy.evaluate(x)[0]))

    def as_round(self, mesh: Mesh, start: Iterate, seconds: float) -> Round:
        """The record of a minimisation from `start`, with the foldings before and after."""
        before, after = (int(folded_faces(x, mesh.f).sum()) for x in (start.x, self.last.x))
        mean = mean_angle_difference(mesh, self.last.x)
        return Round(start.round, start.stage, before, after, self.last.iteration, self.last.energy, mean,
                     self.status, seconds)


def minimize(
    iterates: Iterator[Iterate],
    *,
    tolerance: float,
    max_iterations: int,
    plateau: float = 0.0,
    listener: Listener | None = None,
    round: int = 0,
) -> Minimum:
    """Run a solver until its residual is at most the tolerance, Algorithm 1, step 2.

    The solver yields its start, then every iterate, and ends where no step is acceptable; what the residual is depends
    on the solver. The run has also converged when the lowest energy fell by less than the share `plateau` over the last
    100 steps; 0 switches this rule off. A listener may raise StopIteration. `round` is stamped on the iterates.
    """
    energies: list[float] = []
    status = Status.STALLED
    for k in count():
        iterate = next(iterates, None)
        if iterate is None:
            break
        last = replace(iterate, round=round)
        energies.append(last.energy)
        try:
            if listener is not None:
                listener(last)
        except StopIteration:
            status = Status.STOPPED
            break
        if last.residual <= tolerance or _is_flat(energies, plateau):  # Algorithm 1, step 2
            status = Status.CONVERGED
            break
        if k >= max_iterations:
            status = Status.MAX_ITERATIONS
            break
    return Minimum(last, status)


def _is_flat(energies: list[float], plateau: float) -> bool:
    """True if the lowest energy fell by less than a share of it over the last steps."""
    if plateau == 0 or len(energies) % _WINDOW or len(energies) <= _WINDOW:
        return False
    lowest = min(energies)
    return min(energies[:-_WINDOW]) - lowest < plateau * lowest
