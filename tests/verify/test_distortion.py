"""Angles and areas: identities, libigl's own quantities, and degenerate faces."""

import igl
import numpy as np
from triangulations import icosphere, unit

import igl_spheremap as ism
from igl_spheremap.mesh.measure import corner_angles
from igl_spheremap.sphere.moebius import moebius

X, F = icosphere(3)
V = X * [1, 1.3, 2]


def test_angles_are_libigls_and_sum_to_pi():
    angles = corner_angles(V, F)
    assert np.allclose(angles, igl.internal_angles(V, F))
    assert np.allclose(angles.sum(axis=1), np.pi)


def test_similarities_change_no_angle():
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    assert np.abs(ism.angle_differences(V, F, 3 * V @ turn + 1)).max() < 1e-9


def test_differences_are_image_minus_source_in_degrees():
    expected = np.degrees(igl.internal_angles(X, F) - igl.internal_angles(V, F))
    assert np.allclose(ism.angle_differences(V, F, X), expected)
    assert np.abs(expected).max() > 10


def test_moebius_maps_are_conformal_to_second_order():
    errors = []
    for level in (3, 4, 5):
        x, f = icosphere(level)
        errors.append(np.abs(ism.angle_differences(x, f, moebius(x, [0, 0, 0.4]))).mean())
    assert np.all(np.array(errors[:-1]) / errors[1:] > 1.9)  # angles see first derivatives: first order each


def test_angles_of_degenerate_faces_are_finite_and_right():
    v = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [1e-9, 1e-9, 0], [0, 0, 0], [0.5, 1e-12, 0]], dtype=float)
    angles = np.degrees(corner_angles(v, np.array([[0, 1, 2], [0, 4, 1], [0, 1, 5]])))
    assert np.isfinite(angles).all()
    assert np.allclose(angles[0], [0, 180, 0])
    assert np.allclose(angles[2], [0, 0, 180], atol=1e-6)


def test_tiny_images_keep_their_angles():
    tiny = unit(np.array([0, 0, 1.0]) + 1e-11 * V)
    assert np.abs(corner_angles(tiny[:, [0, 1, 2]], F) - corner_angles(V * [1, 1, 0], F)).mean() < 1e-3


def test_conformal_factor_is_the_ratio_of_lumped_areas():
    ratio = igl.massmatrix(X, F, igl.MASSMATRIX_TYPE_BARYCENTRIC).diagonal() / igl.massmatrix(
        V, F, igl.MASSMATRIX_TYPE_BARYCENTRIC).diagonal()
    area = igl.doublearea(V, F).sum() / 2
    assert np.allclose(ism.conformal_factor(V, F, X), ratio * area)  # eq. (14), the source having unit area


def test_conformal_factor_does_not_see_the_sources_scale():
    assert np.allclose(ism.conformal_factor(V, F, X), ism.conformal_factor(1e-4 * V + 7, F, X))


def test_conformal_factor_integrates_to_the_image_area():
    mass = igl.massmatrix(V, F, igl.MASSMATRIX_TYPE_BARYCENTRIC).diagonal()
    assert np.isclose(mass @ ism.conformal_factor(V, F, X) / mass.sum(), igl.doublearea(X, F).sum() / 2)
