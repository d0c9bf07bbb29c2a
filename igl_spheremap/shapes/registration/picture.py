"""A band-limited function on the sphere with its gradient, for fast repeated evaluation at many points."""

from __future__ import annotations

import numpy as np

from ...mesh.arrays import FloatArray
from ..grid import from_grid
from ..harmonics.basis import degree_of
from ..harmonics.rotation import turning
from ..harmonics.transform import gauss_rows, grid_synthesis

_ROWS_PER_DEGREE = 3  # the error of bilinear lookup is 6 percent at the highest degree, and goes with its square below


class Picture:
    """The function with coefficients ((L + 1)^2, k); a call gives its values (n, k) and gradients (n, k, 3)."""

    def __init__(self, c: FloatArray) -> None:
        rows = _ROWS_PER_DEGREE * (degree_of(c) + 1)
        coefficients = np.concatenate((c, *turning(c)), axis=1)  # x cross grad is band-limited, too
        self._grid = grid_synthesis(coefficients, gauss_rows(rows)[0], 2 * rows)
        self._columns = c.shape[1]

    def __call__(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        read = from_grid(self._grid, x, "gauss")
        values, turns = np.split(read, [self._columns], axis=1)
        across = turns.reshape(len(x), 3, -1).transpose(0, 2, 1)
        return values, np.cross(across, x[:, None])  # (x cross grad) cross x = grad
