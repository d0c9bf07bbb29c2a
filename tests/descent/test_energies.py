"""Energies: their first variations, known cases, and the effect of boosts."""

import igl
import numpy as np
import pytest
from triangulations import icosphere, wild

import igl_spheremap as ism
from igl_spheremap.descent.energies import (
    HarmonicEnergy,
    LandmarkEnergy,
    OwnEnergy,
    SumEnergy,
    p_harmonic_energy,
)
from igl_spheremap.descent.problem import p_harmonic_problem
from igl_spheremap.sphere.moebius import moebius
from igl_spheremap.sphere.rows import tangent, unit_rows

X, F = icosphere(3)
V = X * [1, 1.3, 2]
MESH = ism.check_mesh(V, F)
SMALL, SMALL_F = icosphere(2)
HARMONIC = HarmonicEnergy.of(ism.check_mesh(SMALL * [1, 1.3, 2], SMALL_F))
CHOSEN = np.array([3, 7, 15, 22, 40, 51])


def test_energy_is_that_of_libigls_laplacian():
    x = wild(X)
    # eq. (6)
    assert np.isclose(
        ism.harmonic_energy(V, F, x), -0.5 * np.trace(x.T @ (igl.cotmatrix(V, F) @ x))
    )


def test_energy_does_not_see_the_sources_scale_or_place():
    assert np.isclose(ism.harmonic_energy(1e-5 * V + 1, F, X), ism.harmonic_energy(V, F, X))


def test_energy_is_at_least_the_area_face_by_face():
    x = wild(X)
    cotangents = 1 / np.tan(igl.internal_angles(V, F))
    edges = np.stack(
        [((x[F[:, (k + 1) % 3]] - x[F[:, (k + 2) % 3]]) ** 2).sum(1) for k in range(3)], axis=1
    )
    per_face = (cotangents * edges).sum(axis=1) / 4
    assert np.isclose(per_face.sum(), ism.harmonic_energy(V, F, x))
    assert (per_face >= igl.doublearea(x, F) / 2 - 1e-12).all()


def test_energy_of_the_identity_is_the_area():
    assert np.isclose(ism.harmonic_energy(X, F, X), igl.doublearea(X, F).sum() / 2)


def test_energy_of_moebius_maps_converges_to_four_pi_at_second_order():
    errors = []
    for level in (3, 4, 5):
        x, f = icosphere(level)
        errors.append(abs(ism.harmonic_energy(x, f, moebius(x, [0.3, 0, 0])) - 4 * np.pi))
    assert np.allclose(np.array(errors[:-1]) / errors[1:], 4, rtol=0.1)


def test_the_discrete_energy_falls_along_a_strong_boost():
    """Why boosts are kept out of the descent: its minimiser is a point."""
    towards = unit_rows(X[F[0]].mean(axis=0, keepdims=True))[0]
    assert ism.harmonic_energy(X, F, moebius(X, 0.99999 * towards)) < 0.1 * ism.harmonic_energy(
        X, F, X
    )


def test_faces_without_area_do_not_spoil_the_energy():
    v = V.copy()
    v[F[0, 1]] = v[F[0, 0]]
    assert np.isfinite(ism.harmonic_energy(v, F, X))


@pytest.mark.parametrize("p", [1.2, 1.5, 2, 3, 6])
def test_gradient_is_the_first_variation(p):
    energy, x = p_harmonic_problem(MESH, p).energy, wild(X)
    direction = np.random.default_rng(1).normal(size=x.shape)
    _, gradient = energy.evaluate(x)
    h = 1e-6
    difference = energy.evaluate(x + h * direction)[0] - energy.evaluate(x - h * direction)[0]
    assert np.isclose(difference / (2 * h), np.vdot(gradient, direction), rtol=1e-6)


def test_p_2_is_the_harmonic_energy_with_its_derivatives():
    x = wild(X)
    value, gradient = p_harmonic_problem(MESH, 2).energy.evaluate(x)
    expected, derivative = HarmonicEnergy.of(MESH).evaluate(x)
    assert np.isclose(value, expected, rtol=1e-12)
    assert np.allclose(gradient, derivative, atol=1e-10 * np.abs(derivative).max())


def test_energy_of_a_similarity_is_the_power_of_its_scale():
    """Onto a scaled copy of itself each face has |grad F|^2 = 2 s^2, so that E_p = 2^(p/2) s^p / p."""
    s = np.sqrt(4 * np.pi) * 0.7
    for p in (1.5, 2, 4):
        assert np.isclose(
            p_harmonic_problem(MESH, p).energy.evaluate(s * MESH.unit)[0], 2 ** (p / 2) * s**p / p
        )


def test_energies_are_homogeneous_of_degree_p():
    x = wild(X)
    for p in (1.5, 2, 4):
        energy = p_harmonic_problem(MESH, p).energy
        assert np.isclose(energy.evaluate(3 * x)[0], 3**p * energy.evaluate(x)[0])


def test_powers_are_ordered_by_hoelder():
    """On unit area the p-means of |grad F| rise with p."""
    x = wild(X)
    means = [(p * p_harmonic_energy(V, F, x, p)) ** (1 / p) for p in (1.1, 1.5, 2, 3, 5)]
    assert (np.diff(means) > 0).all()


def test_constant_faces_have_no_gradient_whatever_p():
    x = np.tile([0.0, 0.0, 1.0], (len(X), 1))
    for p in (1.5, 2, 4):
        value, gradient = p_harmonic_problem(MESH, p).energy.evaluate(x)
        assert value == 0
        assert not gradient.any()


def test_boosts_lower_the_energy_below_2_and_raise_it_above():
    """Why the gauge is fixed up to p = 2 only."""
    boosted = moebius(X, [0, 0, 0.8])
    for p, falls in ((1.5, True), (3, False)):
        change = p_harmonic_energy(X, F, boosted, p) - p_harmonic_energy(X, F, X, p)
        assert (change < 0) == falls
        assert p_harmonic_problem(MESH, p).fixes_gauge == falls


def test_the_round_sphere_is_p_harmonic_for_every_p():
    """By symmetry the icosahedron's identity is at rest."""
    x, f = icosphere(0)
    mesh = ism.check_mesh(x, f)
    for p in (1.5, 2, 5):
        _, derivative = p_harmonic_problem(mesh, p).energy.evaluate(unit_rows(x))
        assert np.abs(tangent(unit_rows(x), derivative)).max() < 1e-12


def test_faces_without_area_do_not_spoil_it():
    v = V.copy()
    v[F[0, 1]] = v[F[0, 0]]
    assert np.isfinite(p_harmonic_energy(v, F, X, 3))


def test_the_penalty_is_half_the_weighted_squared_chord():
    """A vertex that is named twice is drawn to both targets."""
    targets = np.array([[0.0, 0, 1], [0, 1, 0], [1, 0, 0]])
    value, gradient = LandmarkEnergy(np.array([1, 1, 2]), targets, np.array([2.0, 3, 0])).evaluate(
        np.eye(3)
    )
    assert value == (2 * 2 + 3 * 0) / 2
    assert np.array_equal(gradient, [[0, 0, 0], [0, 2, -2], [0, 0, 0]])


def test_the_sums_gradient_is_its_first_variation():
    x = wild(SMALL)
    energy = SumEnergy(
        (HARMONIC, LandmarkEnergy(CHOSEN, wild(SMALL, 2)[CHOSEN], np.arange(6) + 0.5))
    )
    direction = np.random.default_rng(1).normal(size=x.shape)
    _, gradient = energy.evaluate(x)
    h = 1e-6
    difference = energy.evaluate(x + h * direction)[0] - energy.evaluate(x - h * direction)[0]
    assert np.isclose(difference / (2 * h), np.vdot(gradient, direction), rtol=1e-6)


def test_energies_add_up():
    x = wild(SMALL)
    terms = (HARMONIC, LandmarkEnergy(CHOSEN, wild(SMALL, 2)[CHOSEN], np.full(6, 2.0)))
    total = SumEnergy(terms).evaluate(x)
    parts = [term.evaluate(x) for term in terms]
    assert np.isclose(total[0], parts[0][0] + parts[1][0])
    assert np.allclose(total[1], parts[0][1] + parts[1][1])


def test_a_users_energy_is_evaluated_as_it_is_and_its_mistakes_are_named():
    x = wild(SMALL)
    for returned in (tuple, list):
        own = OwnEnergy(lambda y, kind=returned: kind((np.float32(y[0, 0]), 2 * y)))
        value, derivatives = own.evaluate(x)
        assert value == np.float32(x[0, 0])
        assert np.array_equal(derivatives, 2 * x)

    def answer(found):
        return OwnEnergy(lambda y: found).evaluate(x)

    for found in (None, 1.0, (1.0,), (1.0, x, x), (x, x), ("1", x), (True, x)):
        with pytest.raises(TypeError, match="did not return a number and an array"):
            answer(found)
    with pytest.raises(ism.MeshError, match="derivatives of the fidelity term"):
        answer((1.0, x[:-1]))
    holed = x.copy()
    holed[[3, 5], 1] = np.nan, np.inf
    with pytest.raises(ValueError, match=r"not finite at 2 vertices, e\.g\. 3, 5"):
        answer((1.0, holed))
    assert answer((np.inf, holed))[0] == np.inf
    with pytest.raises(ValueError, match="read-only"):
        OwnEnergy(lambda y: (0.0, y.__iadd__(1))).evaluate(x)


@pytest.mark.parametrize("p", [1, 0.5, np.inf, np.nan])
def test_a_power_that_gives_no_energy_is_refused(p):
    with pytest.raises(ValueError, match="out of range"):
        p_harmonic_energy(V, F, X, p)
