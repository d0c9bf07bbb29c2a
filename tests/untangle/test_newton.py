"""Newton steps on angle differences: the right derivatives, the right system, and the gauge held."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from triangulations import icosphere, unit

from igl_spheremap.mesh.measure import corner_angles
from igl_spheremap.sphere.rows import tangent_axes
from igl_spheremap.untangle.blocks import VertexBlocks
from igl_spheremap.untangle.newton import AngleNewton
from igl_spheremap.verify.certificate import orientation_signs


@pytest.fixture(scope="module")
def noisy():
    """Steps towards the angles of a sphere, and a noisy sphere."""
    x, f = icosphere(3)
    A = np.full(len(x), 1 / len(x))
    noise = 0.02 * np.random.default_rng(0).normal(size=x.shape)
    blocks, undamped = VertexBlocks(f), np.full(len(x), 1e-8)
    return AngleNewton(blocks, corner_angles(x, f).T, A, A @ x, undamped, systems=100), unit(x + noise)


def test_derivatives_agree_with_differences(noisy):
    newton, x = noisy
    rng, f, h = np.random.default_rng(1), newton.blocks.f, 1e-6
    axes = np.stack(tangent_axes(x), axis=1)
    t = rng.normal(size=(len(x), 2))
    step = h * np.einsum("na,nai->ni", t, axes)
    slope = (corner_angles(x + step, f) - corner_angles(x - step, f)) / (2 * h)
    difference, J = newton._linearised(x, axes)
    assert np.allclose(difference, corner_angles(x, f).T - newton.source, atol=1e-9)
    assert np.allclose(np.einsum("iam,ma->mi", J, t[f].reshape(-1, 6)), slope, rtol=1e-5, atol=1e-5)


def test_the_normal_equations_are_those_of_the_dense_jacobian(noisy):
    newton, x = noisy
    f, n = newton.blocks.f, newton.blocks.n
    J = newton._linearised(x, np.stack(tangent_axes(x), axis=1))[1]
    weight = np.random.default_rng(2).random((3, len(f)))
    dense = np.zeros((3, len(f), 2 * n))
    columns = (2 * f[:, :, None] + [0, 1]).reshape(-1, 6)
    for i in range(3):
        np.add.at(dense[i], (np.arange(len(f))[:, None], columns), J[i].T)
    dense, w = dense.reshape(-1, 2 * n), weight.ravel()
    H = newton.blocks.gram(J * weight[:, None], J)
    assert np.allclose(H.toarray(), dense.T @ (w[:, None] * dense), atol=1e-10)


def test_steps_lead_back_to_the_sphere_quadratically_at_the_end(noisy):
    newton, x = noisy
    differences = [newton.difference(x)]
    for _ in range(6):
        x, _ = newton.step(x, smoothing=1.0)  # plain least squares: the residual vanishes at the solution
        differences.append(newton.difference(x))
        assert (orientation_signs(x, newton.blocks.f) > 0).all()
    assert differences[-1] < 1e-6
    steep = [b / a**2 for a, b in pairwise(differences) if 1e-4 < a < 1]
    assert max(steep) < 10


def test_the_centroid_goes_where_it_is_to_be(noisy):
    newton, x = noisy
    x = unit(x + np.array([0.0, 0.0, 0.05]))
    off_centre = np.linalg.norm(newton.A @ x - newton.centroid)
    for _ in range(4):
        x, _ = newton.step(x, smoothing=1.0)
    assert np.linalg.norm(newton.A @ x - newton.centroid) < 1e-4 * off_centre


def test_a_map_that_has_the_angles_stays(noisy):
    newton, _ = noisy
    x = icosphere(3)[0]
    assert np.abs(newton.step(x, smoothing=0.01)[0] - x).max() < 1e-9


def test_steps_by_conjugate_gradients_gain_nearly_what_exact_ones_do_and_move_the_centroid_as_far(noisy):
    newton, x = noisy
    x = unit(x + np.array([0.0, 0.0, 0.05]))
    before = newton.difference(x)
    (y, exact), (z, about) = (replace(newton, exact=exact).step(x, smoothing=1.0) for exact in (True, False))
    assert before - about > 0.8 * (before - exact) > 0
    moved = newton.A @ (y - x)
    assert np.linalg.norm(newton.A @ (z - x) - moved) < 0.1 * np.linalg.norm(moved)
