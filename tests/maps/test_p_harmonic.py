"""p-harmonic maps: the conformal one at p = 2, stationary ones elsewhere."""

import numpy as np
import pytest
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.descent.problem import p_harmonic_problem
from igl_spheremap.sphere.rows import unit_rows

X, F = icosphere(3)
V = X * [1, 1.3, 2]
MESH = ism.check_mesh(V, F)


def test_p_2_minimises_to_the_conformal_map():
    conformal = ism.spherical_conformal_map(V, F)
    start = unit_rows(conformal.sphere + 0.02 * np.random.default_rng(2).normal(size=X.shape))
    result = ism.p_harmonic_map(V, F, 2, start, gradient_tolerance=1e-3)
    assert result.certificate.folding_free
    assert np.abs(result.sphere - conformal.sphere).max() < 5e-3
    assert np.isclose(result.energy, conformal.energy, rtol=1e-6)


@pytest.mark.parametrize("p", [1.5, 4])
def test_minimisers_are_stationary_and_lower_than_the_conformal_map(p):
    conformal = ism.spherical_conformal_map(V, F)
    result = ism.p_harmonic_map(V, F, p, plateau=1e-10)
    assert result.certificate.folding_free
    before, after = (ism.p_harmonic_energy(V, F, x, p) for x in (conformal.sphere, result.sphere))
    assert after < before - 1e-3
    assert result.energy > conformal.energy
    assert result.gauge == ("free" if p > 2 else "centred")
    problem = p_harmonic_problem(MESH, p)
    _, before = problem.evaluate(conformal.sphere)
    _, after = problem.evaluate(result.sphere)
    assert problem.inner(after, after) < 1e-4 * problem.inner(before, before)


def test_p_must_be_above_one():
    for p in (1, 0.5, np.nan, np.inf):
        with pytest.raises(ValueError, match=r"p is nan; give a number|above 1"):
            ism.p_harmonic_map(V, F, p)
