"""p-harmonic maps, conformal at p = 2 and stationary elsewhere; landmarks, matched by Moebius maps and closer."""

import numpy as np
import pytest
from triangulations import icosphere, random_rotation

import igl_spheremap as ism
from igl_spheremap.descent.energies import HarmonicEnergy, OwnEnergy, SumEnergy, p_harmonic_energy
from igl_spheremap.descent.problem import p_harmonic_problem
from igl_spheremap.maps.variational import check_landmarks, match_landmarks
from igl_spheremap.sphere.moebius import best_rotation, moebius
from igl_spheremap.sphere.rows import unit_rows

X, F = icosphere(3)
V = X * [1, 1.3, 2]
MESH = ism.check_mesh(V, F)
CHOSEN = np.array([3, 77, 150, 222, 400, 512])


def targets(x, size=0.2, seed=0):
    return unit_rows(x[CHOSEN] + size * np.random.default_rng(seed).normal(size=(len(CHOSEN), 3)))


def test_moebius_maps_are_recovered_from_landmarks():
    moved = moebius(X, [0.3, -0.1, 0.2])
    y = moved @ random_rotation()
    found = match_landmarks(X, check_landmarks(len(X), CHOSEN, y[CHOSEN], 1.0), stiffness=0.0)
    assert np.allclose(found, y, atol=1e-6)


def test_landmarks_that_are_matched_already_leave_the_map_conformal():
    # the same energy
    conformal = ism.algorithm_1(V, F, start=ism.spherical_conformal_map(V, F).sphere)
    moved = moebius(conformal.sphere, [0.1, 0.2, 0.0])
    result = ism.landmark_map(V, F, CHOSEN, moved[CHOSEN])
    # .019 to .024: rounding decides where the steps end
    assert np.abs(result.sphere - moved).max() < 0.03
    before = ism.harmonic_energy(V, F, moved)
    assert 0.998 * before < result.energy <= before


def test_landmarks_are_matched_closer_with_more_weight_and_never_fold():
    x = ism.spherical_conformal_map(V, F).sphere
    y = targets(x)
    misses, energies = [], []
    for weight in (1.0, 10.0, 100.0):
        result = ism.landmark_map(V, F, CHOSEN, y, landmark_weights=weight)
        assert result.certificate.folding_free
        assert result.gauge == "free"
        misses.append(np.linalg.norm(result.sphere[CHOSEN] - y, axis=1).mean())
        energies.append(result.energy)
    assert misses[0] > 2 * misses[1] > 4 * misses[2]
    assert misses[2] < 0.02
    assert energies == sorted(energies)


def test_foldings_of_strong_landmarks_are_reported_and_avoided_by_default():
    x = ism.spherical_conformal_map(V, F).sphere
    y = targets(x, 0.5, seed=3)
    loose = ism.landmark_map(V, F, CHOSEN, y, landmark_weights=1000.0, may_fold=True)
    assert loose.rounds[0].foldings_after == loose.certificate.foldings > 0
    injective = ism.landmark_map(V, F, CHOSEN, y, landmark_weights=1000.0)
    assert injective.certificate.folding_free
    start = np.linalg.norm(
        match_landmarks(x, check_landmarks(len(X), CHOSEN, y, 1.0))[CHOSEN] - y, axis=1
    )
    assert np.linalg.norm(injective.sphere[CHOSEN] - y, axis=1).mean() < 0.5 * start.mean()


def test_landmarks_are_met_on_a_body_with_limbs_too():
    """A face of a limb is thin: it would fold on the way, which must not hold up the landmarks."""
    v, f = ism.samples.make("dino", n_vertices=1500)
    chosen = np.linspace(0, len(v) - 1, 40).astype(int)
    places = ism.spherical_conformal_map(v, f).sphere[chosen]
    y = unit_rows(places + 0.2 * np.random.default_rng(1).normal(size=places.shape))

    def miss(iterations):
        result = ism.landmark_map(
            v, f, chosen, y, landmark_weights=100.0, max_iterations=iterations
        )
        assert result.certificate.folding_free
        return np.linalg.norm(result.sphere[chosen] - y, axis=1).mean()

    assert miss(300) < 0.5 * miss(0)


def test_a_turned_problem_has_a_turned_answer():
    """Rounding sends the two descents apart: they meet at the minimum, as near to it as the tolerance asks for."""
    x = ism.spherical_conformal_map(V, F).sphere
    y = targets(x)
    quarter = np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    straight, turned = (
        ism.landmark_map(
            V, F, CHOSEN, y @ R, landmark_weights=10.0, sobolev_gradient_tolerance=1e-4, plateau=0.0
        )
        for R in (np.eye(3), quarter)
    )
    assert straight.status is turned.status is ism.Status.CONVERGED
    assert np.abs(straight.sphere @ quarter - turned.sphere).max() < 2e-3


def test_the_history_holds_the_objective_and_the_result_the_harmonic_energy():
    x = ism.spherical_conformal_map(V, F).sphere
    y = targets(x)
    result = ism.landmark_map(V, F, CHOSEN, y, landmark_weights=5.0)
    penalty = 2.5 * ((result.sphere[CHOSEN] - y) ** 2).sum()
    assert np.isclose(result.energy, ism.harmonic_energy(V, F, result.sphere))
    assert np.isclose(result.history[-1].energy, result.energy + penalty)


@pytest.mark.parametrize(
    ("where", "goal", "weight", "words"),
    [
        ([0, 9999], np.eye(3)[:2], 1, "landmark 1 is vertex 9999"),
        ([0.5], np.eye(3)[:1], 1, "whole number"),
        ([0, 1], np.eye(3), 1, "2 landmarks have 3 targets"),
        (
            [0, 1],
            np.zeros((2, 3)),
            1,
            "landmark targets are zero or not finite in 2 rows, e.g. 0, 1",
        ),
        ([0, 1], np.eye(3)[:2], [1, -1], "weight of landmark 1"),
        ([0, 1], np.eye(3)[:2], [1, 2, 3], "one for each of 2 landmarks"),
    ],
)
def test_bad_landmarks_are_named(where, goal, weight, words):
    with pytest.raises(ism.MeshError, match=words):
        ism.landmark_map(V, F, where, goal, landmark_weights=weight)


def test_p_2_minimises_to_the_conformal_map():
    conformal = ism.spherical_conformal_map(V, F)
    start = unit_rows(conformal.sphere + 0.02 * np.random.default_rng(2).normal(size=X.shape))
    result = ism.p_harmonic_map(V, F, 2, start=start, gradient_tolerance=1e-3)
    assert result.certificate.folding_free
    assert np.abs(result.sphere - conformal.sphere).max() < 5e-3
    assert np.isclose(result.energy, conformal.energy, rtol=1e-6)


@pytest.mark.parametrize("p", [1.5, 4])
def test_minimisers_are_stationary_and_lower_than_the_conformal_map(p):
    conformal = ism.spherical_conformal_map(V, F)
    result = ism.p_harmonic_map(V, F, p, plateau=1e-10)
    assert result.certificate.folding_free
    before, after = (p_harmonic_energy(V, F, x, p) for x in (conformal.sphere, result.sphere))
    assert after < before - 1e-3
    assert result.energy > conformal.energy
    assert result.gauge == ("free" if p > 2 else "centred")
    problem = p_harmonic_problem(MESH, p)
    _, before = problem.evaluate(conformal.sphere)
    _, after = problem.evaluate(result.sphere)
    assert problem.metric.inner(after, after) < 1e-4 * problem.metric.inner(before, before)


def test_p_must_be_above_one():
    for p in (1, 0.5, np.nan, np.inf):
        with pytest.raises(ValueError, match=r"p is nan; give a number|above 1"):
            ism.p_harmonic_map(V, F, p)


def curve(x, vertices, weight):
    """Half the weighted sum of squared heights above the equator."""
    derivatives = np.zeros_like(x)
    derivatives[vertices, 2] = weight * x[vertices, 2]
    return 0.5 * weight * (x[vertices, 2] ** 2).sum(), derivatives


def test_derivatives_of_a_sum_with_a_term_are_its_first_variation():
    x, t = (np.random.default_rng(k).normal(size=X.shape) for k in (0, 1))
    landmarks = check_landmarks(len(X), CHOSEN, targets(X), 3.0)
    terms = HarmonicEnergy.of(MESH), landmarks, OwnEnergy(lambda x: curve(x, CHOSEN, 5.0))
    for energy in (*terms, SumEnergy(terms)):
        rise = (energy.evaluate(x + 1e-4 * t)[0] - energy.evaluate(x - 1e-4 * t)[0]) / 2e-4
        assert np.isclose((energy.evaluate(x)[1] * t).sum(), rise, rtol=1e-9)  # all are quadratic


def test_landmarks_are_a_fidelity_term_of_ones_own():
    x = ism.spherical_conformal_map(V, F).sphere
    penalty = check_landmarks(len(X), CHOSEN, targets(x), 10.0)

    def own(x):
        off = x[CHOSEN] - penalty.targets
        derivatives = np.zeros_like(x)
        derivatives[CHOSEN] = 10 * off
        return 5 * (off**2).sum(), derivatives

    by_name, by_term, by_own = (
        ism.landmark_map(
            V, F, CHOSEN, targets(x), landmark_weights=10.0, start=x, max_iterations=20
        ),
        ism.fidelity_map(V, F, penalty.evaluate, start=x, max_iterations=20),
        ism.fidelity_map(V, F, own, start=x, max_iterations=20),
    )
    assert np.array_equal(by_name.sphere, by_term.sphere)
    assert np.abs(by_name.sphere - by_own.sphere).max() < 1e-9
    assert (by_own.method, by_own.gauge, by_own.settings) == (
        "fidelity",
        "free",
        {"max_iterations": 20},
    )


def test_a_term_with_a_known_minimiser_is_minimised():
    """The identity of a subdivided icosahedron is harmonic by symmetry, and nearest to itself."""
    x, f = icosphere(1)

    def distance(y):
        return 10 * ((y - x) ** 2).sum(), 20 * (y - x)

    start = moebius(x, [0.1, 0.2, -0.1]) @ best_rotation(
        x, x + 0.3 * x[:, [1, 2, 0]], np.ones(len(x))
    )
    result = ism.fidelity_map(
        x, f, distance, start=start, sobolev_gradient_tolerance=1e-9, plateau=0.0
    )
    assert result.certificate.folding_free
    assert np.abs(result.sphere - x).max() < 1e-8


def test_a_curve_is_drawn_to_the_equator_while_the_map_stays_centred():
    x = ism.spherical_conformal_map(V, F).sphere
    near = np.flatnonzero(np.abs(V @ [1.0, 0.3, 0.4]) < 0.12)
    start = x @ [[0, 0, 1], [1, 0, 0], [0, 1, 0]]
    heights, energies = [np.abs(start[near, 2]).max()], [ism.harmonic_energy(V, F, start)]
    for weight in (1.0, 10.0, 100.0):
        result = ism.fidelity_map(
            V, F, lambda y, w=weight: curve(y, near, w), start=start, gauge="centred"
        )
        assert result.certificate.folding_free
        assert np.linalg.norm(MESH.A @ result.sphere) < 1e-8
        heights.append(np.abs(result.sphere[near, 2]).max())
        energies.append(result.energy)
    assert heights == sorted(heights, reverse=True)
    assert heights[-1] < 0.1 * heights[0]
    assert energies == sorted(energies)


@pytest.mark.parametrize(
    ("term", "error", "message"),
    [
        (3, TypeError, "fidelity is 3; give a function"),
        (lambda x: 1.0, TypeError, r"return its value and its \(642, 3\) derivatives"),
        (lambda x: ("1", x), TypeError, r"return its value and its \(642, 3\) derivatives"),
        (lambda x: (x, x), TypeError, r"return its value and its \(642, 3\) derivatives"),
        (lambda x: (1.0, x[1:]), ism.MeshError, "derivatives of the fidelity term have 641 rows"),
        (lambda x: (np.nan, x), ValueError, "nan at the start"),
        (
            lambda x: (1.0, x / (x[:, :1] != x[7, 0])),
            ValueError,
            r"not finite at \d+ vert\w+, e.g. ",
        ),
        (lambda x: (float(x.sort() or 0), x), ValueError, "read-only"),
    ],
)
def test_terms_that_are_none_are_refused(term, error, message):
    with pytest.raises(error, match=message):
        ism.fidelity_map(V, F, term, start=X)
