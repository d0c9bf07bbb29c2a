"""Rules of the program that reference [18] published, where the paper says nothing or something else.

It is OptManiMulitBallGBB for columns of unit length, of the package OptM by Wen and Yin.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from ..descent.line_search import NonmonotoneSearch
from ..mesh.arrays import FloatArray
from ..result.run import Iterate
from .safeguards import AsPrinted

#: Trials of a search, of which the last is taken.
_TRIALS = 5
#: Changes of map and energy that are small, and the number of steps whose means are looked at.
_CHANGES, _RECENT = np.array([1e-6, 1e-12]), 5
#: Bounds of the quotients of eq. (12).
_LEAST_TAU, _LARGEST_TAU = 1e-20, 1e20


class AsProgrammed(AsPrinted):
    """The program's bounds of searches and of eq. (12); it ends a run, too, where map and energy hardly change."""

    def __init__(self, tau: float) -> None:
        super().__init__()
        self._first = tau
        self._before: Iterate | None = None
        self._changes: deque[FloatArray] = deque(maxlen=_RECENT)

    def search(self, energy: float, rho: float, delta: float, xi: float) -> NonmonotoneSearch:
        """A search that takes its fifth trial."""
        return NonmonotoneSearch(energy, rho, delta, xi, _TRIALS, takes_last=True)

    def settled(self, last: Iterate) -> bool:
        """True if the last step changed map and energy by less than their tolerances.

        True, too, if the last five steps did on average by less than ten times as much.
        """
        before, self._before = self._before, last
        if before is None or not last.iteration:
            self._changes.clear()
            return False
        x = np.linalg.norm(last.x - before.x) / np.sqrt(3)
        self._changes.append(np.array([x, abs(last.energy - before.energy) / (1 + abs(before.energy))]))
        mean = np.mean(self._changes, axis=0)
        return bool((self._changes[-1] < _CHANGES).all() or (mean < 10 * _CHANGES).all())

    def step(self, tau: float, taken: float) -> float:
        """The quotient within bounds; the first step of the run in place of 0, infinity and NaN."""
        tau = super().step(tau, self._first)
        bounded = min(max(tau, _LEAST_TAU), _LARGEST_TAU)
        self._count("bounded", bounded != tau)
        return bounded
