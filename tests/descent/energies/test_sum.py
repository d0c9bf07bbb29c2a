"""Sums of energies."""

import numpy as np
from triangulations import icosphere, wild

import igl_spheremap as ism
from igl_spheremap.descent.energies.harmonic import HarmonicEnergy
from igl_spheremap.descent.energies.landmarks import LandmarkEnergy
from igl_spheremap.descent.energies.sum import SumEnergy

X, F = icosphere(2)
HARMONIC = HarmonicEnergy.of(ism.check_mesh(X * [1, 1.3, 2], F))
CHOSEN = np.array([3, 7, 15, 22, 40, 51])


def test_the_sums_gradient_is_its_first_variation():
    x = wild(X)
    energy = SumEnergy((HARMONIC, LandmarkEnergy(CHOSEN, wild(X, 2)[CHOSEN], np.arange(6) + 0.5)))
    direction = np.random.default_rng(1).normal(size=x.shape)
    _, gradient = energy.evaluate(x)
    h = 1e-6
    difference = energy.evaluate(x + h * direction)[0] - energy.evaluate(x - h * direction)[0]
    assert np.isclose(difference / (2 * h), np.vdot(gradient, direction), rtol=1e-6)


def test_energies_add_up():
    x = wild(X)
    terms = (HARMONIC, LandmarkEnergy(CHOSEN, wild(X, 2)[CHOSEN], np.full(6, 2.0)))
    total = SumEnergy(terms).evaluate(x)
    parts = [term.evaluate(x) for term in terms]
    assert np.isclose(total[0], parts[0][0] + parts[1][0])
    assert np.allclose(total[1], parts[0][1] + parts[1][1])
