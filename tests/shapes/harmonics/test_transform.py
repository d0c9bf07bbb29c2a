"""Quadrature and transforms on grids: exact for what they resolve."""

from __future__ import annotations

import numpy as np
import pytest

from igl_spheremap.shapes.harmonics.basis import synthesis
from igl_spheremap.shapes.harmonics.transform import analysis, gauss_rows, grid_points, grid_synthesis, longitudes


@pytest.mark.parametrize("n", [1, 2, 7, 60])
def test_gauss_rows_are_those_of_numpy(n):
    z, w = gauss_rows(n)
    known = np.polynomial.legendre.leggauss(n)
    assert np.abs(z[::-1] - known[0]).max() < 1e-14
    assert np.abs(w[::-1] - known[1]).max() < 1e-14


def test_gauss_rows_integrate_up_to_degree_2n_minus_1_and_no_further():
    z, w = gauss_rows(5)
    for k in range(10):
        assert np.isclose(w @ z**k, (1 + (-1) ** k) / (k + 1), atol=1e-15)
    assert abs(w @ z**10 - 2 / 11) > 1e-4


@pytest.mark.parametrize(("degree", "bound"), [(0, 1e-15), (1, 1e-14), (50, 1e-12), (200, 5e-11)])
def test_round_trip(degree, bound):
    c = np.random.default_rng(degree).normal(size=((degree + 1) ** 2, 2))
    z, w = gauss_rows(degree + 1)
    assert np.abs(analysis(grid_synthesis(c, z, 2 * degree + 2), z, w, degree) - c).max() <= bound


def test_grids_agree_with_points():
    c = np.random.default_rng(0).normal(size=(31**2, 3))
    z, phi = np.cos([0.0, 0.4, 2.0, np.pi]), longitudes(64)
    pointwise = synthesis(c, grid_points(z, phi).reshape(-1, 3)).reshape(4, 64, 3)
    assert np.abs(grid_synthesis(c, z, 64) - pointwise).max() < 1e-12
