"""Area and edge distortion."""

import numpy as np
import pytest

import igl_spheremap as ism

X, F = ism.samples.sphere(642)


def test_a_similarity_distorts_nothing():
    turned = X @ np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    assert np.abs(ism.area_distortion(5 * turned - 2, F, X)).max() < 1e-12
    assert np.abs(ism.edge_distortion(5 * turned - 2, F, X)).max() < 1e-12


def test_areas_and_edges_of_a_stretched_plane_patch_change_as_its_determinant_and_lengths():
    v = X * [1, 1, 3]
    area, edge = ism.area_distortion(v, F, X), ism.edge_distortion(v, F, X)
    assert area.shape == (len(F),)
    assert edge.shape == F.shape
    cap = np.abs(X[F][..., 2]).min(axis=1) > 0.9  # nearly across z: kept in size, but for the normalisation
    side = np.abs(X[F][..., 2]).max(axis=1) < 0.2  # nearly along z: three times as large
    assert area[cap].mean() - area[side].mean() == pytest.approx(np.log(3), abs=0.25)
    for k in range(3):  # column k is the edge opposite corner k
        i, j = F[:, (k + 1) % 3], F[:, (k + 2) % 3]
        ratio = np.linalg.norm(X[i] - X[j], axis=1) / np.linalg.norm(v[i] - v[j], axis=1)
        assert np.ptp(edge[:, k] - np.log(ratio)) < 1e-12


def test_faces_of_zero_area_are_infinite_not_an_error():
    v = X.copy()
    v[F[0, 0]] = v[F[0, 1]]
    assert np.isinf(ism.area_distortion(v, F, X)[0])
    assert ism.balanced_spherical_map(v, F, 1).certificate.folding_free
