"""Problems: the gradient along the sphere, the gauge, and the areas that it balances."""

from dataclasses import replace

import igl
import numpy as np
import pytest
from triangulations import icosphere, wild

import igl_spheremap as ism
from igl_spheremap.descent.problem import harmonic_problem, remove_boosts
from igl_spheremap.sphere.moebius import center
from igl_spheremap.sphere.rows import tangent

X, F = icosphere(3)
V = X * [1, 1.3, 2]
MESH = ism.check_mesh(V, F)
PROBLEM = harmonic_problem(MESH)


@pytest.mark.parametrize("gauge", [True, False])
def test_gradient_is_the_derivative_along_the_sphere(gauge):
    x = wild(X)
    problem = replace(PROBLEM, gauge=gauge)
    direction = tangent(x, np.random.default_rng(1).normal(size=x.shape))
    if gauge:
        direction = remove_boosts(x, direction, PROBLEM.A)
    _, gradient = problem.evaluate(x)
    h = 1e-6
    values = [problem.evaluate(ism.cayley_update(x, -direction, s))[0] for s in (h, -h)]
    assert np.isclose((values[0] - values[1]) / (2 * h), problem.inner(gradient, direction), rtol=1e-6)


def test_gradient_has_neither_radial_part_nor_boost_nor_rotation():
    x = center(wild(X), PROBLEM.A)
    _, gradient = PROBLEM.evaluate(x)
    assert np.abs((gradient * x).sum(axis=1)).max() < 1e-9 * np.abs(gradient).max()
    for e in np.eye(3):
        assert abs(PROBLEM.inner(gradient, tangent(x, np.tile(e, (len(x), 1))))) < 1e-9
        assert abs(PROBLEM.inner(gradient, np.cross(e, x))) < 1e-9


def test_areas_are_libigls_mass_and_never_vanish():
    mass = igl.massmatrix(MESH.v, F, igl.MASSMATRIX_TYPE_BARYCENTRIC).diagonal()
    assert np.allclose(PROBLEM.A, mass)  # eq. (13)
    flat = V.copy()
    flat[F[0]] = flat[F[0, 0]]
    assert ism.check_mesh(flat, F).A.min() > 0
