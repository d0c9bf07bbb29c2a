"""A map's changes of angles and areas: identities, and libigl's own quantities."""

from __future__ import annotations

import warnings

import igl
import numpy as np
import pytest
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap import angle_differences, conformal_factor, samples, spherical_conformal_map
from igl_spheremap.sphere.moebius import moebius
from igl_spheremap.verify.distortion import (
    angle_figures,
    log_figures,
    mean_angle_difference,
    vertex_maps,
)

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
    # angles see first derivatives: first order each
    assert np.all(np.array(errors[:-1]) / errors[1:] > 1.9)


def test_conformal_factor_is_the_ratio_of_lumped_areas():
    ratio = (
        igl.massmatrix(X, F, igl.MASSMATRIX_TYPE_BARYCENTRIC).diagonal()
        / igl.massmatrix(V, F, igl.MASSMATRIX_TYPE_BARYCENTRIC).diagonal()
    )
    area = igl.doublearea(V, F).sum() / 2
    # eq. (14), the source having unit area
    assert np.allclose(ism.conformal_factor(V, F, X), ratio * area)


def test_conformal_factor_does_not_see_the_sources_scale():
    assert np.allclose(ism.conformal_factor(V, F, X), ism.conformal_factor(1e-4 * V + 7, F, X))


def test_conformal_factor_integrates_to_the_image_area():
    mass = igl.massmatrix(V, F, igl.MASSMATRIX_TYPE_BARYCENTRIC).diagonal()
    assert np.isclose(
        mass @ ism.conformal_factor(V, F, X) / mass.sum(), igl.doublearea(X, F).sum() / 2
    )


def test_a_similarity_distorts_nothing():
    turned = X @ np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    assert np.abs(ism.log_area_ratios(5 * turned - 2, F, X)).max() < 1e-12
    assert np.abs(ism.log_length_ratios(5 * turned - 2, F, X)).max() < 1e-12


def test_areas_and_edges_of_a_stretched_plane_patch_change_as_its_determinant_and_lengths():
    v = X * [1, 1, 3]
    area, edge = ism.log_area_ratios(v, F, X), ism.log_length_ratios(v, F, X)
    assert area.shape == (len(F),)
    assert edge.shape == F.shape
    # nearly across z: kept in size, but for the normalisation
    cap = np.abs(X[F][..., 2]).min(axis=1) > 0.9
    side = np.abs(X[F][..., 2]).max(axis=1) < 0.2  # nearly along z: three times as large
    assert area[cap].mean() - area[side].mean() == pytest.approx(np.log(3), abs=0.25)
    for k in range(3):  # column k is the edge opposite corner k
        i, j = F[:, (k + 1) % 3], F[:, (k + 2) % 3]
        ratio = np.linalg.norm(X[i] - X[j], axis=1) / np.linalg.norm(v[i] - v[j], axis=1)
        assert np.ptp(edge[:, k] - np.log(ratio)) < 1e-12


def test_faces_of_zero_area_are_infinite_not_an_error():
    v = X.copy()
    v[F[0, 0]] = v[F[0, 1]]
    assert np.isinf(ism.log_area_ratios(v, F, X)[0])
    assert ism.balanced_spherical_map(v, F, balance=1).certificate.folding_free


def test_the_maps_are_what_they_say():
    result = spherical_conformal_map(*samples.make("spheroid", n_vertices=600))
    maps = vertex_maps(result.vertices * 7, result.faces, result.sphere)
    factor = conformal_factor(result.vertices, result.faces, result.sphere)
    assert np.allclose(np.exp(2 * maps["factor"]) * 4 * np.pi, factor)
    size = np.abs(angle_differences(result.vertices, result.faces, result.sphere))
    for i in (0, 100, 500):
        assert maps["angles"][i] == pytest.approx(size[result.faces == i].mean())


@pytest.mark.parametrize("name", ["spheroid", "pear"])
def test_the_conformal_factor_satisfies_equation_24_at_second_order(name):
    """Tested by low harmonics: pointwise, second differences of areas do not converge on irregular meshes.

    With the operator of eq. (15) it is Delta u - K + e^{2u} = 0; the paper has the opposite sign before Delta u.
    """
    errors = []
    for n in (1000, 4000, 16000):
        v, f = ism.samples.make(name, n_vertices=n)
        v = v / np.sqrt(igl.doublearea(v, f).sum() / 2)
        x, A = (
            ism.spherical_conformal_map(v, f).sphere,
            np.bincount(f.ravel(), np.repeat(igl.doublearea(v, f) / 6, 3)),
        )
        factor = conformal_factor(v, f, x)
        residual = (
            igl.cotmatrix(v, f) @ np.log(factor) / 2 - igl.gaussian_curvature(v, f) + A * factor
        )
        tests = np.column_stack((np.ones(len(x)), x, x**2, x * np.roll(x, 1, axis=1)))
        errors.append([abs(residual.sum()), np.abs(tests.T @ residual).max()])
    ratios = np.array(errors[:-1]) / errors[1:]
    assert ((ratios > 3.6) & (ratios < 4.4)).all(), ratios


def test_figures_are_those_of_numpy():
    d = np.random.default_rng(0).normal(size=(50, 3))
    expected = {
        "mean": np.abs(d).mean(),
        "p99": np.percentile(np.abs(d), 99),
        "max": np.abs(d).max(),
    }
    assert log_figures(d) == expected
    assert angle_figures(d) == expected | {
        "median": np.median(np.abs(d)),
        "p95": np.percentile(np.abs(d), 95),
    }


def test_ratios_of_zero_areas_are_left_out():
    assert log_figures(np.array([0.5, -1.5, np.inf, -np.inf, np.nan])) == log_figures(
        np.array([0.5, 1.5])
    )


def test_a_surface_without_any_area_has_no_figures_but_a_summary():
    """All vertices at two points: no face has an area, so that no logarithm is finite."""
    x, f = ism.samples.sphere(42)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = ism.spherical_conformal_map(np.where(x[:, [0]] > 0, 1.0, 0.0) * [1, 0, 0], f)
        assert np.isnan(list(log_figures(result.log_area_ratios()).values())).all()
        assert "nan-fold on average" in result._repr_html_()


def test_areas_below_the_least_float_have_their_logarithms():
    """The star of a vertex, shrunk 1e200 times about it: each of its faces loses 2 log(1e200)."""
    star = np.unique(F[(F == 0).any(axis=1)])
    x = V - V[0]
    inside, before = np.isin(F, star).all(axis=1), igl.doublearea(x, F)
    x[star] *= 1e-200
    total = np.log(igl.doublearea(x, F).sum() / before.sum())
    found = ism.log_area_ratios(V, F, x)
    assert np.allclose(found[inside], -2 * np.log(1e200) - total, atol=1e-9)
    assert log_figures(found)["max"] > 900
    assert np.isfinite(vertex_maps(V, F, x)["factor"]).all()


def test_a_surface_with_a_hole_is_measured_face_by_face():
    assert np.array_equal(ism.angle_differences(V, F[10:], X), ism.angle_differences(V, F, X)[10:])
    with pytest.raises(ism.MeshError, match="index out of range"):
        ism.angle_differences(V, F + 1, X)


def test_the_mean_difference_is_the_mean_size_of_all_differences_but_of_caps():
    v, f = icosphere(2)
    body, x = v * [1, 1.3, 1.7], moebius(v, [0.2, 0.3, -0.1])
    caps = np.arange(len(f)) < 40
    off = np.abs(ism.angle_differences(body, f, x))
    assert off.mean() > 1
    assert np.isclose(mean_angle_difference(ism.check_mesh(body, f), x), off.mean())
    capped = ism.check_mesh(body, f, caps=caps)
    assert np.isclose(mean_angle_difference(capped, x), off[~caps].mean())
