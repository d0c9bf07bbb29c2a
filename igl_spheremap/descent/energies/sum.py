"""Energies added up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...mesh.arrays import FloatArray
from . import Energy


@dataclass(frozen=True, eq=False)
class SumEnergy:
    """The sum of its terms, each with its own weight inside it."""

    terms: tuple[Energy, ...]

    def evaluate(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Sum of the values and of the derivatives."""
        values, gradients = zip(*(term.evaluate(x) for term in self.terms), strict=True)
        return float(sum(values)), np.sum(gradients, axis=0)
