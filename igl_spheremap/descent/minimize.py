"""The only iteration loop: it draws iterates from a solver, tells listeners, and decides when to end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import count

import numpy as np
from numpy.typing import NDArray

from .iterate import Iterate, Listener, Status

FloatArray = NDArray[np.float64]


#: Steps over which a plateau is judged: Barzilai-Borwein energies go up and down over some tens.
_WINDOW = 100


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where a minimisation ended.

    Attributes
    ----------
    last : Iterate
        The last iterate.
    status : Status
        Why it was the last.
    energies : (k + 1,) float64 array
        Energy of every iterate, the start first.
    residuals : (k + 1,) float64 array
        What the stopping rule looked at, for every iterate.
    """

    last: Iterate
    status: Status
    energies: FloatArray
    residuals: FloatArray


def minimize(
    iterates: Iterator[Iterate],
    *,
    tolerance: float,
    max_iterations: int,
    plateau: float = 0.0,
    listener: Listener | None = None,
    round: int = 0,
) -> Minimum:
    """Run a solver until its residual is small.

    Parameters
    ----------
    iterates : iterator of Iterate
        What a solver yields: its start, then every iterate; it ends where no step is acceptable.
    tolerance : float
        The run has converged when the residual is at most this, Algorithm 1, step 2. Each solver says what its
        residual is.
    max_iterations : int
        The run ends after so many steps.
    plateau : float
        The run has also converged when the lowest energy fell by less than this share of it over the last 100 steps.
        0 switches this rule off.
    listener : callable, optional
        Called with every iterate; may raise StopIteration.
    round : int
        Folding-removal round to stamp on the iterates.

    Returns
    -------
    Minimum
        The last iterate, why it was the last, and the course of energy and residual.
    """
    energies: list[float] = []
    residuals: list[float] = []
    status = Status.STALLED
    for k in count():
        iterate = next(iterates, None)
        if iterate is None:
            break
        last = replace(iterate, round=round)
        last.x.flags.writeable = False
        energies.append(last.energy)
        residuals.append(last.residual)
        try:
            if listener is not None:
                listener(last)
        except StopIteration:
            status = Status.STOPPED
            break
        if last.residual <= tolerance or _flat(energies, plateau):  # Algorithm 1, step 2
            status = Status.CONVERGED
            break
        if k == max_iterations:
            status = Status.MAX_ITERATIONS
            break
    return Minimum(last, status, np.array(energies), np.array(residuals))


def _flat(energies: list[float], plateau: float) -> bool:
    """True if the lowest energy has hardly changed over the last steps."""
    if plateau == 0 or len(energies) % _WINDOW or len(energies) <= _WINDOW:
        return False
    lowest = min(energies)
    return min(energies[:-_WINDOW]) - lowest < plateau * lowest
