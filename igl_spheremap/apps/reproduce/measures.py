"""Figures of an outcome: angles, and how two runs compare at one and the same energy."""

from __future__ import annotations

import numpy as np

from ...verify.distortion import angle_differences
from .runs import Outcome
from .surfaces import Surface

#: Share by which an energy may miss the common one and still count as having reached it.
_REACHED = 1e-6


def mean_angle(surface: Surface, outcome: Outcome) -> float:
    """Mean size of the angle differences of a run's result in degrees; NaN if there is no map."""
    if outcome.foldings < 0:
        return float("nan")
    return float(np.abs(angle_differences(surface.v, surface.f, outcome.sphere)).mean())


def to_common_energy(first: Outcome, second: Outcome) -> tuple[tuple[int, float], tuple[int, float]] | None:
    """Iterations and CPU seconds of both runs down to the lowest energy that both reach; None if one has no map.

    Their own stopping rules end them at different places: only this compares work for work.

    >>> def course(*energies):
    ...     e = np.array(energies, dtype=float)
    ...     return Outcome("", 0.0, energies=e, clock=np.arange(len(e)) / 10)
    >>> to_common_energy(course(9, 5, 4, 3), course(9, 8, 7, 6, 5, 4.5))
    ((2, 0.2), (5, 0.5))
    """
    if not len(first.energies) or not len(second.energies):
        return None
    target = max(first.energies.min(), second.energies.min()) * (1 + _REACHED)
    (a, s), (b, t) = (_reach(outcome, target) for outcome in (first, second))
    return (a, s), (b, t)


def _reach(outcome: Outcome, energy: float) -> tuple[int, float]:
    k = int(np.argmax(outcome.energies <= energy))
    return k, float(outcome.clock[k])
