"""Rules of the program that reference [18] published, where the paper says nothing or something else.

It is OptManiMulitBallGBB for columns of unit length, of the package OptM by Wen and Yin.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np

from ..mesh.arrays import FloatArray
from ..result.run import Iterate
from .safeguards import AsPrinted

#: Trials of a search, of which the last is taken.
TRIALS = 5
#: Changes of map and energy that are small, and the number of steps whose means are looked at.
_CHANGES, _RECENT = np.array([1e-6, 1e-12]), 5
#: Bounds of the quotients of eq. (12).
_LEAST_TAU, _LARGEST_TAU = 1e-20, 1e20


class AsProgrammed(AsPrinted):
    """The program's bounds on eq. (12), and its first step where the quotient has no value."""

    def __init__(self, tau: float) -> None:
        super().__init__()
        self._first = tau

    def step(self, tau: float, taken: float) -> float:
        """The quotient within bounds; the first step of the run in place of 0, infinity and NaN."""
        tau = super().step(tau, self._first)
        bounded = min(max(tau, _LEAST_TAU), _LARGEST_TAU)
        self._count("bounded", bounded != tau)
        return bounded


def small_changes() -> Callable[[Iterate], bool]:
    """A rule that ends a run: map and energy hardly change.

    True if the last step changed both by less than their tolerances, or the last five on average by less than ten times
    as much.
    """
    before: Iterate | None = None
    recent: deque[FloatArray] = deque(maxlen=_RECENT)

    def settled(last: Iterate) -> bool:
        nonlocal before
        if before is not None and last.iteration:
            x = np.linalg.norm(last.x - before.x) / np.sqrt(3)
            recent.append(np.array([x, abs(last.energy - before.energy) / (1 + abs(before.energy))]))
        before = last
        return bool(recent) and bool((recent[-1] < _CHANGES).all() or (np.mean(recent, axis=0) < 10 * _CHANGES).all())

    return settled
