"""The Cayley update against the equation that it solves, and the paper's closed form."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from triangulations import random_points

import igl_spheremap as ism
from igl_spheremap.sphere.rows import tangent

FINITE = st.floats(-50, 50).map(lambda t: round(t, 6))


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


@given(
    arrays(float, (4, 3), elements=FINITE),
    st.floats(-3, 3).map(lambda t: round(t, 6)),
    st.integers(0, 99),
)
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


def test_each_row_has_its_direction():
    with pytest.raises(ism.MeshError, match="directions have 19 rows"):
        ism.cayley_update(random_points(20), random_points(19), 1.0)


def test_cayley_path_starts_along_the_negative_gradient():
    x = random_points()
    h = np.random.default_rng(1).normal(size=x.shape)
    speed = (ism.cayley_update(x, h, 1e-6) - ism.cayley_update(x, h, -1e-6)) / 2e-6
    assert np.allclose(speed, -tangent(x, h), atol=1e-8)
