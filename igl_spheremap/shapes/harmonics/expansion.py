"""Coefficients of data over a mapped mesh, by exact quadrature on a Gauss grid."""

from __future__ import annotations

import math

from ...mesh.arrays import FloatArray
from ..locate import SphereLocator
from ..transfer import interpolate
from .transform import analysis, gauss_rows, grid_points, longitudes


def expand(locator: SphereLocator, values: FloatArray, degree: int, oversampling: float) -> FloatArray:
    """Coefficients ((L + 1)^2, k) of the piecewise linear function with these values (n, k) at the vertices.

    Vertex sums and least squares lose by orders where vertices crowd: see docs/shapes.md.
    """
    n = math.ceil(oversampling * degree) + 2
    z, w = gauss_rows(n)
    location = locator.locate(grid_points(z, longitudes(2 * n)).reshape(-1, 3))
    return analysis(interpolate(values, locator.f, location).reshape(n, 2 * n, -1), z, w, degree)
