"""The race: candidates take a few steps each, the best half goes on, until one is left and would gain too little.

Starts do not show their ends: a map of 16 degrees may end below a layout of 8. Only steps show the best, and they take
most of the time. So all candidates take rough ones, and few take whole ones: successive halving (Jamieson and Talwalkar
2016, *Non-stochastic Best Arm Identification and Hyperparameter Optimization*).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter

import numpy as np

from ..mesh.arrays import HALF_DIGITS, FloatArray


@dataclass(frozen=True, eq=False)
class Candidate:
    """A certified map, its mean angle difference in degrees, and the stretch and gauge of its limbs, see `Run`.

    Further steps are predicted to lower the mean by the share `further`; infinite if nothing predicts it.
    """

    x: FloatArray
    mean: float
    stretch: float = 1.0
    gauge: str = "centred"
    further: float = np.inf


def race(
    field: Sequence[Candidate], steps: Callable[[Candidate], Candidate], price: float
) -> Candidate:
    """The best of several candidates, after rounds of steps that make none worse.

    Each round keeps the better half. A candidate goes on while its next round is expected to lower the mean angle
    difference by more than the share `price`. The expectation is the prediction of its last steps, but at most its last
    round's gain. Rounds end when the last candidate stops.
    """
    while len(field) > 1 or field[0].further > price:
        field = sorted(field, key=attrgetter("mean"))[: max(1, len(field) // 2)]
        for k, before in enumerate(field):
            if before.further > price:
                after = steps(before)
                gain = (before.mean - after.mean) / max(before.mean, HALF_DIGITS)
                field[k] = replace(after, further=min(after.further, gain))
    return field[0]
