"""The harmonic energy: libigl's Laplacian, the face-by-face bound, and its derivatives."""

from dataclasses import replace

import igl
import numpy as np
import pytest
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.descent.problem import harmonic_problem, remove_boosts
from igl_spheremap.operators.laplacian import positive_areas
from igl_spheremap.sphere.moebius import center, moebius
from igl_spheremap.sphere.rows import tangent, unit_rows

X, F = icosphere(3)
V = X * [1, 1.3, 2]
MESH = ism.check_mesh(V, F)
PROBLEM = harmonic_problem(MESH)


def wild(seed=0):
    return unit_rows(X + 0.5 * np.random.default_rng(seed).normal(size=X.shape))


def test_energy_is_that_of_libigls_laplacian():
    x = wild()
    assert np.isclose(ism.harmonic_energy(V, F, x), -0.5 * np.trace(x.T @ (igl.cotmatrix(V, F) @ x)))  # eq. (6)


def test_energy_does_not_see_the_sources_scale_or_place():
    assert np.isclose(ism.harmonic_energy(1e-5 * V + 1, F, X), ism.harmonic_energy(V, F, X))


def test_energy_is_at_least_the_area_face_by_face():
    x = wild()
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


@pytest.mark.parametrize("gauge", [True, False])
def test_gradient_is_the_derivative_along_the_sphere(gauge):
    x = wild()
    problem = replace(PROBLEM, gauge=gauge)
    direction = tangent(x, np.random.default_rng(1).normal(size=x.shape))
    if gauge:
        direction = remove_boosts(x, direction, PROBLEM.A)
    _, gradient = problem.evaluate(x)
    h = 1e-6
    values = [problem.evaluate(ism.cayley_update(x, -direction, s))[0] for s in (h, -h)]
    assert np.isclose((values[0] - values[1]) / (2 * h), problem.inner(gradient, direction), rtol=1e-6)


def test_gradient_has_neither_radial_part_nor_boost_nor_rotation():
    x = center(wild(), PROBLEM.A)
    _, gradient = PROBLEM.evaluate(x)
    assert np.abs((gradient * x).sum(axis=1)).max() < 1e-9 * np.abs(gradient).max()
    for e in np.eye(3):
        assert abs(PROBLEM.inner(gradient, tangent(x, np.tile(e, (len(x), 1))))) < 1e-9
        assert abs(PROBLEM.inner(gradient, np.cross(e, x))) < 1e-9


def test_areas_are_libigls_mass_and_never_vanish():
    mass = igl.massmatrix(MESH.v, F, igl.MASSMATRIX_TYPE_BARYCENTRIC).diagonal()
    assert np.allclose(PROBLEM.A, mass)  # eq. (13)
    flat = V.copy()
    flat[F[0]] = flat[F[0, 0]]
    assert positive_areas(ism.check_mesh(flat, F)).min() > 0


def test_faces_without_area_do_not_spoil_the_energy():
    v = V.copy()
    v[F[0, 1]] = v[F[0, 0]]
    assert np.isfinite(ism.harmonic_energy(v, F, X))
