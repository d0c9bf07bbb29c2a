"""The nonmonotone search of Zhang and Hager, as Algorithm 1 uses it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Literal, TypeVar

T = TypeVar("T")
#: Which quotient of eq. (12) is the first step tried.
BarzilaiBorwein = Literal["alternating", "tau_1", "tau_2"]
#: What ends Algorithm 1: the norm of the gradient, step 2, or this and the rule of Wen and Yin's program.
Stop = Literal["gradient", "wen-yin"]


@dataclass(frozen=True)
class Accepted(Generic[T]):
    """A step that the search accepts: its size, the energy there, and what else the trial returned."""

    tau: float
    energy: float
    trial: T


@dataclass
class NonmonotoneSearch:
    """Backtracking against a running average of the energies seen, Algorithm 1, steps 3 and 5.

    Zhang and Hager 2004, *A nonmonotone line search technique and its application to unconstrained optimization*.

    >>> search = NonmonotoneSearch(energy=1.0)
    >>> step = search.search(lambda tau: ((1 - tau) ** 2, None), tau=4.0, slope=-2.0)
    >>> round(step.tau, 3)
    0.4
    """

    #: The energy at the start, C_0.
    energy: float
    #: Share of the predicted decrease that is asked for.
    rho: float = 1e-4
    #: Factor by which a refused step is shortened.
    delta: float = 0.1
    #: Memory of the average: 0 is the monotone Armijo search, 1 averages over all iterates.
    xi: float = 0.85
    #: Trials after which no step is taken to exist: with delta = 0.1 the step is below rounding long before 40.
    trials: int = 40
    #: Whether the last trial is taken whatever its energy, if that is finite.
    takes_last: bool = False

    def __post_init__(self) -> None:
        self._C = self.energy
        self._Q = 1.0

    def search(self, trial: Callable[[float], tuple[float, T]], tau: float, slope: float) -> Accepted[T] | None:
        """Shorten `tau` until the energy is below the line that starts at the running average.

        `trial` takes a step size, and returns the energy there and whatever the caller wants back; `slope` is the
        derivative of the energy along the path at 0. None if no trial is acceptable.
        """
        for k in range(1, self.trials + 1):
            energy, extra = trial(tau)
            last = self.takes_last and k == self.trials and math.isfinite(energy)
            if energy <= self._C + self.rho * tau * slope or last:  # Algorithm 1, step 3; a NaN is refused
                return Accepted(tau, energy, extra)
            tau *= self.delta
        return None

    def record(self, energy: float) -> None:
        """Take the energy E(F_{k+1}) of a new iterate into the average."""
        Q = self.xi * self._Q + 1  # Algorithm 1, step 5
        self._C = (self.xi * self._Q * self._C + energy) / Q
        self._Q = Q
