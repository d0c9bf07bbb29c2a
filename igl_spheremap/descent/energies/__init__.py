"""Energies of a map to the sphere, one file each."""

from __future__ import annotations

from typing import Protocol

from ...mesh.arrays import FloatArray


class Energy(Protocol):
    """A differentiable function of the map."""

    def evaluate(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Value at `x` and the (n, 3) array of its derivatives by the coordinates."""
        ...
