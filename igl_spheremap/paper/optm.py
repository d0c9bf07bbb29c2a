"""Rules of the program that the paper's reference [18] published, where the paper leaves them open or differs.

It is OptManiMulitBallGBB for columns of unit length, of the package OptM by Wen and Yin.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from ..descent.line_search import NonmonotoneSearch
from ..mesh.arrays import FloatArray
from ..result.run import Iterate
from .hooks import Hooks

#: Number of steps that a search tries; the last one is taken in any case.
TRIALS = 5
#: A run ends if its last step changes map and energy by less than these, or its last five on average by ten times
#: these.
_CHANGES, _RECENT = np.array([1e-6, 1e-12]), 5
#: Bounds of the quotients of eq. (12).
_LEAST_TAU, _LARGEST_TAU = 1e-20, 1e20


class OptMRules(Hooks):
    """The program's bounds on searches and on eq. (12), and its second end of a run: map and energy hardly change."""

    def __init__(self, tau: float) -> None:
        super().__init__()
        self._first = tau
        self._before: Iterate | None = None
        self._changes: deque[FloatArray] = deque(maxlen=_RECENT)

    def search(self, energy: float, rho: float, delta: float, xi: float) -> NonmonotoneSearch:
        """A search that accepts its fifth trial at any finite energy."""
        return NonmonotoneSearch(energy, rho, delta, xi, TRIALS, takes_last=True)

    def settled(self, last: Iterate) -> bool:
        """True if the last step changed map and energy by less than their tolerances.

        Also true if the last five steps changed them on average by less than ten times these tolerances.
        """
        before, self._before = self._before, last
        if before is None or not last.iteration:
            self._changes.clear()
            return False
        x = np.linalg.norm(last.x - before.x) / np.sqrt(3)
        self._changes.append(
            np.array([x, abs(last.energy - before.energy) / (1 + abs(before.energy))])
        )
        mean = np.mean(self._changes, axis=0)
        return bool((self._changes[-1] < _CHANGES).all() or (mean < 10 * _CHANGES).all())

    def step(self, tau: float, taken: float) -> float:
        """The quotient of eq. (12) within bounds; if it is 0, infinite or NaN, the run's first step."""
        tau = super().step(tau, self._first)
        bounded = min(max(tau, _LEAST_TAU), _LARGEST_TAU)
        self._count("bounded", bounded != tau)
        return bounded
