"""Moebius maps keep cross-ratios, and centring undoes them; the gauge sees neither them nor the surface's motion."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from triangulations import icosphere, random_points, random_rotation, unit

from igl_spheremap import check_mesh
from igl_spheremap.sphere.moebius import (
    best_rotation,
    center,
    conformal_barycentre,
    fix_gauge,
    moebius,
    orientation_target,
)


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


def test_centring_gives_up_where_half_the_weight_is_at_one_point():
    x = random_points(50)
    weights = np.where(np.arange(50) == 0, 1.0, 1e-6)
    assert np.isfinite(center(x, weights)).all()


def test_best_rotation_recovers_a_rotation_and_never_mirrors():
    x = random_points()
    turn = random_rotation(4)
    assert np.allclose(best_rotation(x, x @ turn, np.ones(200)), turn)
    assert np.isclose(np.linalg.det(best_rotation(x, x * [1, 1, -1], np.ones(200))), 1)
    assert np.isclose(np.linalg.det(best_rotation(x, np.zeros_like(x), np.ones(200))), 1)


def test_the_gauge_does_not_see_moebius_maps_and_turns_with_the_surface():
    x, f = icosphere(3)
    v = x * [1, 1.3, 2]
    mesh = check_mesh(v, f)
    turn = random_rotation(4)
    expected = fix_gauge(mesh, x)
    assert np.abs(mesh.A @ expected).max() < 1e-9
    assert np.allclose(fix_gauge(mesh, moebius(x, [0.3, -0.5, 0.6]) @ turn), expected, atol=1e-9)
    turned = check_mesh(v @ turn, f)
    assert np.allclose(fix_gauge(turned, x), expected @ turn, atol=1e-9)


@pytest.mark.parametrize("length", [0.0, 0.3, 0.9, 0.999])
def test_the_barycentre_is_what_was_moved_from_the_origin(length):
    weights = np.random.default_rng(2).uniform(0.1, 1, size=500)
    balanced = center(random_points(500), weights)
    c = length * unit(np.array([[0.3, -0.5, 0.6]]))[0]
    x = moebius(balanced, -c)
    found = conformal_barycentre(x, weights)
    assert np.abs(found - c).max() < 1e-7
    assert np.allclose(moebius(x, found), center(x, weights))
    assert np.abs(weights @ center(x, weights)).max() < 1e-9 * weights.sum()


def test_a_mean_within_the_given_distance_is_left_alone():
    x = random_points(500)
    weights = np.ones(500)
    off = float(np.linalg.norm(x.mean(axis=0)))
    assert center(x, weights, within=1.01 * off) is x
    assert np.linalg.norm(center(x, weights, within=0.99 * off).mean(axis=0)) < 0.99 * off


@pytest.mark.parametrize("mirrored", [1, -1])
def test_the_best_rotation_is_scipys(mirrored):
    """Also where a reflection would be better than any rotation."""
    x, target = random_points(100), random_points(100, seed=5)
    target += x * [1, 1.1, mirrored * 0.9]
    weights = np.random.default_rng(2).uniform(0.1, 1, size=100)
    theirs = Rotation.align_vectors(target, x, weights)[0].as_matrix()
    assert np.allclose(best_rotation(x, target, weights), theirs.T)


@pytest.mark.parametrize("outwards", [True, False])
def test_the_gauge_agrees_best_with_normals_and_then_with_places(outwards):
    """Of a flat body the normals say nothing about turns in its plane."""
    x, f = icosphere(3)
    lopsided = x * [1, 1.3, 2] * np.exp(0.3 * x[:, :1])
    # half of it in caps, so that the areas' centre is not that of the surface
    mesh = check_mesh(
        lopsided, f if outwards else f[:, ::-1], caps=x[f][:, :, 2].mean(axis=1) > 0.3
    )
    result = fix_gauge(mesh, moebius(x, [0.3, -0.5, 0.6]) @ random_rotation(4))
    assert np.allclose(
        best_rotation(result, orientation_target(mesh), mesh.A), np.eye(3), atol=1e-9
    )
    place = mesh.unit - mesh.A @ mesh.unit
    side = 1 if outwards else -1
    assert np.allclose(orientation_target(mesh), mesh.normals + side * place / 1000)
