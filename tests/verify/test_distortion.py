"""What a map does to angles and areas: identities, and libigl's own quantities."""

import igl
import numpy as np
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.sphere.moebius import moebius

X, F = icosphere(3)
V = X * [1, 1.3, 2]


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
