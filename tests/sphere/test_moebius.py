"""Geometry of the sphere: closed forms against the definitions that they solve."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from triangulations import unit

import igl_spheremap as ism
from igl_spheremap.sphere.gauge import best_rotation
from igl_spheremap.sphere.moebius import center, conformal_barycentre, moebius
from igl_spheremap.sphere.rows import tangent

FINITE = st.floats(-50, 50).map(lambda t: round(t, 6))


def random_points(n=200, seed=0):
    return unit(np.random.default_rng(seed).normal(size=(n, 3)))


def implicit_step(x, h, tau):
    """Eq. (10), solved row by row."""
    y = np.empty_like(x)
    for k, (a, b) in enumerate(zip(x, h, strict=True)):
        A = np.outer(b, a) - np.outer(a, b)
        y[k] = np.linalg.solve(np.eye(3) + tau / 2 * A, (np.eye(3) - tau / 2 * A) @ a)
    return y


def theorem_1(x, h, tau):
    """The coefficients alpha and beta as the paper prints them."""
    fh, ff, hh = (x * h).sum(1), (x * x).sum(1), (h * h).sum(1)
    below = 1 - (tau / 2) ** 2 * fh**2 + (tau / 2) ** 2 * ff * hh
    alpha = ((1 + tau / 2 * fh) ** 2 - (tau / 2) ** 2 * ff * hh) / below
    beta = -tau * ff / below
    return alpha[:, None] * x + beta[:, None] * h


@given(arrays(float, (4, 3), elements=FINITE), st.floats(-3, 3).map(lambda t: round(t, 6)), st.integers(0, 99))
@settings(max_examples=60, deadline=None)
def test_cayley_update_solves_the_implicit_equation_and_is_the_papers_closed_form(h, tau, seed):
    x = random_points(4, seed)
    y = ism.cayley_update(x, h, tau)
    assert np.allclose(y, implicit_step(x, h, tau), atol=1e-9)
    assert np.allclose(y, theorem_1(x, h, tau), atol=1e-7)


def test_cayley_update_takes_rows_of_any_length():
    x = 3 * random_points(20)
    h = np.random.default_rng(1).normal(size=x.shape)
    assert np.allclose(ism.cayley_update(x, h, 0.3), implicit_step(x, h, 0.3))
    assert np.allclose(ism.cayley_update(x, h, 0.3), theorem_1(x, h, 0.3))


@pytest.mark.parametrize("tau", [0, 1e-300, 1e-8, 1, -1, 1e8, 1e200, -1e300])
def test_cayley_update_keeps_the_norm_for_every_step(tau):
    x = random_points()
    h = np.random.default_rng(1).normal(size=x.shape)
    h[:5] = 7 * x[:5]  # nothing to do along the normal
    assert np.abs(np.linalg.norm(ism.cayley_update(x, h, tau), axis=1) - 1).max() < 1e-14


def test_cayley_path_starts_along_the_negative_gradient():
    x = random_points()
    h = np.random.default_rng(1).normal(size=x.shape)
    speed = (ism.cayley_update(x, h, 1e-6) - ism.cayley_update(x, h, -1e-6)) / 2e-6
    assert np.allclose(speed, -tangent(x, h), atol=1e-8)


def test_moebius_takes_its_centre_to_the_origin_and_keeps_cross_ratios():
    x = random_points(8)
    c = np.array([0.3, -0.5, 0.6])
    y = moebius(x, c)
    def cross_ratio(p):
        d = np.linalg.norm(p[:, None] - p[None], axis=2)
        return d[0, 1] * d[2, 3] / (d[0, 2] * d[1, 3]), d[4, 5] * d[6, 7] / (d[4, 6] * d[5, 7])
    assert np.allclose(cross_ratio(x), cross_ratio(y))
    assert np.allclose(moebius(y, -c), x)
    assert np.allclose(moebius(np.array([c / np.linalg.norm(c)]), c), c / np.linalg.norm(c))


def test_moebius_refuses_a_centre_outside_the_ball():
    with pytest.raises(ValueError, match="unit ball"):
        moebius(random_points(3), [1.0, 0, 0])


@pytest.mark.parametrize("strength", [0.0, 0.5, 0.9, 0.999, 1 - 1e-7])
def test_centring_undoes_any_boost(strength):
    x = random_points(500)
    weights = np.random.default_rng(2).uniform(0.1, 1, size=500)
    x = center(x, weights)
    y = moebius(x, strength * unit(np.ones((1, 3)))[0])
    back = center(y, weights)
    assert np.abs(weights @ back).max() < 1e-7 * weights.sum()
    assert np.allclose(back @ best_rotation(back, x, weights), x, atol=1e-6)


def test_the_barycentre_of_a_balanced_set_is_the_origin():
    x = random_points(50)
    assert np.abs(conformal_barycentre(np.vstack((x, -x)), np.ones(100))).max() < 1e-12


def test_centring_copes_with_a_crowd_near_one_point():
    x = unit(np.array([0, 0, 1.0]) + 1e-6 * np.random.default_rng(3).normal(size=(300, 3)))
    assert np.abs(center(x, np.ones(300)).mean(axis=0)).max() < 1e-9


def test_best_rotation_recovers_a_rotation_and_never_mirrors():
    x = random_points()
    turn = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    assert np.allclose(best_rotation(x, x @ turn, np.ones(200)), turn)
    assert np.isclose(np.linalg.det(best_rotation(x, x * [1, 1, -1], np.ones(200))), 1)
    assert np.isclose(np.linalg.det(best_rotation(x, np.zeros_like(x), np.ones(200))), 1)


def test_centring_gives_up_where_half_the_weight_is_at_one_point():
    x = random_points(50)
    weights = np.where(np.arange(50) == 0, 1.0, 1e-6)
    assert np.isfinite(center(x, weights)).all()
