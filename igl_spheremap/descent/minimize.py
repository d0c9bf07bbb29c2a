"""The loop around every first-order solver: it draws iterates, notifies a listener, and decides when to end."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import count

import numpy as np

from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..result.run import Iterate, Listener, Round, Status
from ..verify.distortion import mean_angle_difference
from ..verify.signs import folded_faces
from .line_search import Stop
from .problem import Problem

#: Steps over which a plateau is judged: Barzilai-Borwein energies oscillate with periods of tens.
_WINDOW = 100
#: Changes of map and energy that are small, and the number of steps whose mean is looked at: xtol, ftol and nt of Wen
#: and Yin's program OptStiefelGBB.
_CHANGES, _RECENT = np.array([1e-6, 1e-12]), 5


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where a minimisation ended, and why there."""

    last: Iterate
    status: Status

    def centred(self, problem: Problem) -> Minimum:
        """The minimum in the gauge of the result, unless rounding there folds a face of a map without foldings."""
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
    stop: Stop = "gradient",
    listener: Listener | None = None,
    round: int = 0,
) -> Minimum:
    """Run a solver until its residual is at most the tolerance, Algorithm 1, step 2.

    The solver yields its start, then every iterate, and ends where no step is acceptable; what the residual is depends
    on the solver. By `stop` "wen-yin" the run has converged, too, when map and energy hardly change. It ends at a
    plateau when the lowest energy fell by less than the share `plateau` over the last 100 steps; 0 switches this rule
    off. A listener may raise StopIteration. `round` is stamped on the iterates.
    """
    energies: list[float] = []
    changes = _Changes()
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
        if last.residual <= tolerance or (stop == "wen-yin" and changes.are_small(last)):  # Algorithm 1, step 2
            status = Status.CONVERGED
            break
        if _is_flat(energies, plateau):
            status = Status.PLATEAU
            break
        if k >= max_iterations:
            status = Status.MAX_ITERATIONS
            break
    return Minimum(last, status)


class _Changes:
    """The rule of Wen and Yin's program OptStiefelGBB, besides the gradient: map and energy hardly change.

    Wen and Yin 2013, *A feasible method for optimization with orthogonality constraints*, reference [18].
    """

    def __init__(self) -> None:
        self._before: Iterate | None = None
        self._recent: deque[FloatArray] = deque(maxlen=_RECENT)

    def are_small(self, last: Iterate) -> bool:
        """True if the last step changed both by less than their tolerances, or the last five by ten times as much."""
        before, self._before = self._before, last
        if before is None:
            return False
        x = np.linalg.norm(last.x - before.x) / np.sqrt(len(last.x))
        energy = abs(last.energy - before.energy) / (1 + abs(before.energy))
        self._recent.append(np.array([x, energy]))
        mean = np.mean(self._recent, axis=0)
        return bool((self._recent[-1] < _CHANGES).all() or (mean < 10 * _CHANGES).all())


def _is_flat(energies: list[float], plateau: float) -> bool:
    """True if the lowest energy fell by less than a share of it over the last steps."""
    if plateau == 0 or len(energies) % _WINDOW or len(energies) <= _WINDOW:
        return False
    lowest = min(energies)
    return min(energies[:-_WINDOW]) - lowest < plateau * lowest
