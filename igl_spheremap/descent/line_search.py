"""The nonmonotone search of Zhang and Hager, as Algorithm 1 uses it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from ..mesh.arrays import FloatArray
from .energies import Energy


class Accepted(NamedTuple):
    """A step that a search has accepted, and the map that it leads to, with its energy and the derivatives."""

    tau: float
    x: FloatArray
    energy: float
    derivative: FloatArray


@dataclass
class NonmonotoneSearch:
    """Backtracking against a running average of the energies seen, Algorithm 1, steps 3 and 5.

    Zhang and Hager 2004, *A nonmonotone line search technique and its application to unconstrained optimization*.

    >>> search = NonmonotoneSearch(energy=1.0)
    >>> [round(tau, 3) for tau in search.steps(4.0) if search.accepts((1 - tau) ** 2, tau, slope=-2.0)][0]
    0.4
    """

    #: The energy at the start, C_0.
    energy: float
    #: Required share of the predicted decrease.
    rho: float = 1e-4
    #: Factor by which a refused step is shortened.
    delta: float = 0.1
    #: Memory of the average: 0 is the monotone Armijo search, 1 averages over all iterates.
    xi: float = 0.85
    #: Steps that are tried at most: with delta = 0.1 a step is below rounding long before 40.
    trials: int = 40
    #: Whether the last of them is accepted at any finite energy.
    takes_last: bool = False

    def __post_init__(self) -> None:
        self._C, self._Q = self.energy, 1.0  # Algorithm 1, step 1

    def steps(self, tau: float) -> Iterator[float]:
        """Yield the steps to try, ``tau delta^h`` for h = 0, 1, ..."""
        for h in range(self.trials):
            self._is_last = h == self.trials - 1
            yield tau
            tau *= self.delta

    def accepts(self, energy: float, tau: float, slope: float) -> bool:
        """Whether the energy at a step lies below the line from the running average; a NaN does not.

        `slope` is the derivative of the energy along the path at 0.
        """
        if self.takes_last and self._is_last and math.isfinite(energy):
            return True
        return energy <= self._C + self.rho * tau * slope  # Algorithm 1, step 3

    def record(self, energy: float) -> None:
        """Take the energy E(F_{k+1}) of a new iterate into the average."""
        Q = self.xi * self._Q + 1  # Algorithm 1, step 5
        self._C = (self.xi * self._Q * self._C + energy) / Q
        self._Q = Q


def line_search(
    search: NonmonotoneSearch,
    energy: Energy,
    path: Callable[[float], FloatArray | None],
    tau: float,
    slope: float,
) -> Accepted | None:
    """The first of the search's steps from `tau` on that it accepts; None if it accepts none.

    `path` takes a step to its map, a refused one to None.
    """
    for step in search.steps(tau):  # Algorithm 1, step 3
        Y = path(step)
        if Y is None:
            continue
        E, H = energy.evaluate(Y)
        if search.accepts(E, step, slope):
            return Accepted(step, Y, E, H)
    return None
