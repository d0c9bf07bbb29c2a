"""The harmonic energy: libigl's Laplacian, the face-by-face bound, and what boosts do to it."""

import igl
import numpy as np
from triangulations import icosphere, wild

import igl_spheremap as ism
from igl_spheremap.sphere.moebius import moebius
from igl_spheremap.sphere.rows import unit_rows

X, F = icosphere(3)
V = X * [1, 1.3, 2]


def test_energy_is_that_of_libigls_laplacian():
    x = wild(X)
    assert np.isclose(ism.harmonic_energy(V, F, x), -0.5 * np.trace(x.T @ (igl.cotmatrix(V, F) @ x)))  # eq. (6)


def test_energy_does_not_see_the_sources_scale_or_place():
    assert np.isclose(ism.harmonic_energy(1e-5 * V + 1, F, X), ism.harmonic_energy(V, F, X))


def test_energy_is_at_least_the_area_face_by_face():
    x = wild(X)
    cotangents = 1 / np.tan(igl.internal_angles(V, F))
    edges = np.stack([((x[F[:, (k + 1) % 3]] - x[F[:, (k + 2) % 3]]) ** 2).sum(1) for k in range(3)], axis=1)
    per_face = (cotangents * edges).sum(axis=1) / 4
    assert np.isclose(per_face.sum(), ism.harmonic_energy(V, F, x))
    assert (per_face >= igl.doublearea(x, F) / 2 - 1e-12).all()


def test_energy_of_the_identity_is_the_area():
    assert np.isclose(ism.harmonic_energy(X, F, X), igl.doublearea(X, F).sum() / 2)


def test_energy_of_moebius_maps_converges_to_four_pi_at_second_order():
    errors = []
    for level in (3, 4, 5):
        x, f = icosphere(level)
        errors.append(abs(ism.harmonic_energy(x, f, moebius(x, [0.3, 0, 0])) - 4 * np.pi))
    assert np.allclose(np.array(errors[:-1]) / errors[1:], 4, rtol=0.1)


def test_the_discrete_energy_falls_along_a_strong_boost():
    """Why boosts are kept out of the descent: its minimiser is a point."""
    towards = unit_rows(X[F[0]].mean(axis=0, keepdims=True))[0]
    assert ism.harmonic_energy(X, F, moebius(X, 0.99999 * towards)) < 0.1 * ism.harmonic_energy(X, F, X)


def test_faces_without_area_do_not_spoil_the_energy():
    v = V.copy()
    v[F[0, 1]] = v[F[0, 0]]
    assert np.isfinite(ism.harmonic_energy(v, F, X))
