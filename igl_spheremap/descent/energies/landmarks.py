"""The landmark term: a quadratic penalty on where chosen vertices go."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...mesh.arrays import FloatArray, IntArray
from ...sphere.rows import row_dots


@dataclass(frozen=True, eq=False)
class LandmarkEnergy:
    """Half the weighted sum of the squared chords between landmarks and their targets, which are unit rows."""

    vertices: IntArray
    targets: FloatArray
    weights: FloatArray

    def evaluate(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Value and derivatives, which are zero but at landmarks."""
        off = x[self.vertices] - self.targets
        gradient = np.zeros_like(x)
        np.add.at(gradient, self.vertices, self.weights[:, None] * off)
        return 0.5 * float(self.weights @ row_dots(off, off)), gradient
