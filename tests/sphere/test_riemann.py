"""Stereographic projection and its inverse, and Moebius maps by their determining data."""

import numpy as np
import pytest
from triangulations import random_points, random_rotation

import igl_spheremap as ism


def cross_ratios(x):
    d = np.linalg.norm(x[:, None] - x[None], axis=2)
    return d[0, 1] * d[2, 3] / (d[0, 2] * d[1, 3]), d[4, 5] * d[6, 7] / (d[4, 6] * d[5, 7])


def test_the_projection_is_undone_at_every_scale():
    x = np.vstack((random_points(100), np.eye(3), -np.eye(3)))
    x = np.vstack((x, [[1e-9, 0, 1], [0, -1e-160, -1], [3e-8, 4e-8, 1]]))
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    z = ism.stereographic(x)
    assert np.allclose(ism.inverse_stereographic(z), x, rtol=1e-14, atol=1e-15)
    finite = np.isfinite(z) & (x[:, 2] < 0.9)
    assert np.allclose(z[finite], (x[finite, 0] + 1j * x[finite, 1]) / (1 - x[finite, 2]))
    assert np.isinf(ism.stereographic([[0, 0, 1]])).all()
    far = np.array([1e300, -1e-300j, complex(np.inf, 0), complex(0, -np.inf)])
    poles = ism.inverse_stereographic(far)[:, 2].tolist()
    assert poles == [1, -1, 1, 1]


def test_rotations_about_the_axis_are_rotations_of_the_plane():
    x, angle = random_points(20), np.exp(0.7j)
    turned = ism.inverse_stereographic(angle * ism.stereographic(x))
    assert np.allclose((turned[:, 0] + 1j * turned[:, 1]), angle * (x[:, 0] + 1j * x[:, 1]))


def test_three_points_determine_a_moebius_map():
    x, sources = random_points(12), random_points(3)
    c = np.array([0.4, -0.5, 0.6])
    known = ism.moebius_map(x, c) @ random_rotation(3)
    through = ism.moebius_through(x, x[:3], known[:3])
    assert np.allclose(through, known)
    targets = np.array([[0, 0, 1], [0, 0, -1], [1.0, 0, 0]])
    assert np.allclose(ism.moebius_through(sources, sources, targets), targets)
    assert np.allclose(cross_ratios(through), cross_ratios(x))


def test_moebius_through_needs_three_different_points():
    same = np.array([[0, 0, 1], [1, 0, 0], [0, 0, 2.0]])
    with pytest.raises(ism.MeshError, match="targets 0 and 2 coincide"):
        ism.moebius_through(np.eye(3), np.eye(3), same)


def test_recentring_finds_the_gauge_of_results():
    result = ism.spherical_conformal_map(*ism.samples.make("bunny", n_vertices=900))
    moved = ism.moebius_map(result.sphere, [0.2, 0.5, -0.6])
    again = ism.recentre(moved, result.mesh.A)
    u, _, vt = np.linalg.svd(again.T @ result.sphere)
    assert np.linalg.det(u @ vt) > 0
    assert np.allclose(again @ (u @ vt), result.sphere, atol=1e-8)


def test_weights_at_one_point_can_not_be_balanced():
    with pytest.raises(ism.MeshError, match="half of them"):
        ism.recentre(np.eye(3), [3, 1, 1])
    with pytest.raises(ism.MeshError, match="negative"):
        ism.recentre(np.eye(3), [3, -1, 1])


@pytest.mark.parametrize("call", [ism.stereographic, lambda x: ism.moebius_map(x, [0, 0, 0])])
def test_points_without_a_direction_are_named(call):
    with pytest.raises(ism.MeshError, match=r"points .* in 1 row, e\.g\. 1"):
        call([[0, 0, 1], [0, 0, 0]])
    with pytest.raises(ism.MeshError, match=r"points .* in 1 row, e\.g\. 0"):
        call([[0, np.nan, 1]])
