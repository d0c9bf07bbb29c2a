"""The race: candidates take a few steps each, the best half goes on, until one is left and gains no more.

Which of several starts leads to the best map can't be seen from the starts: a map of 16 degrees may end below a layout
of 8. Steps show it, and take most of the time. So all take rough ones, and few take whole ones: successive halving
(Jamieson and Talwalkar 2016, *Non-stochastic Best Arm Identification and Hyperparameter Optimization*).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import attrgetter

from ..mesh.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Candidate:
    """A certified map, its mean angle difference in degrees, and how its limbs are held (`Run`)."""

    x: FloatArray
    mean: float
    stretch: float = 1.0
    gauge: str = "centred"


def race(field: Sequence[Candidate], steps: Callable[[Candidate], Candidate], price: float) -> Candidate:
    """The best of several candidates, after rounds of steps that make none worse.

    Only the better half takes each round. Rounds end with one that gains the last candidate at most the share `price`.
    """
    while True:
        before = sorted(field, key=attrgetter("mean"))[:max(1, len(field) // 2)]
        field = list(map(steps, before))
        if len(field) == 1 and field[0].mean >= (1 - price) * before[0].mean:
            return field[0]
