"""The Gauss map, and the weighted eigenproblem: exact integrals, the spectrum of the sphere, and Theorem 2."""

import igl
import numpy as np
import pytest
from scipy.linalg import eigh
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.descent.energies import HarmonicEnergy
from igl_spheremap.descent.problem import Problem, l2_metric
from igl_spheremap.mesh.measure import vertex_areas, vertex_normals
from igl_spheremap.paper.star_map import (
    finite_conformal_factor,
    project,
    project_unweighted,
    stiffness,
    weighted_mass,
)
from igl_spheremap.sphere.moebius import moebius
from igl_spheremap.verify.signs import folded_faces

X, F = icosphere(3)
MESH = ism.check_mesh(X * [1, 1.2, 1.5], F)


def test_mass_matrix_of_unit_weight_is_libigls_full_one():
    full = igl.massmatrix(MESH.unit, F, igl.MASSMATRIX_TYPE_FULL)
    assert np.abs(weighted_mass(MESH, np.ones(len(X))) - full).max() < 1e-15


def test_mass_matrix_integrates_cubic_products_exactly():
    """Against a quadrature of degree 4 on every face (Dunavant 1985)."""
    rng = np.random.default_rng(0)
    p, q, w = rng.normal(size=(3, len(X)))
    w = w**2
    a, b = 0.445948490915965, 0.091576213509771
    points = (
        [(1 - 2 * s, s, s) for s in (a, b)]
        + [(s, 1 - 2 * s, s) for s in (a, b)]
        + [(s, s, 1 - 2 * s) for s in (a, b)]
    )
    share = [0.223381589678011, 0.109951743655322] * 3
    area = igl.doublearea(MESH.unit, F) / 2
    at = [[g[F] @ np.array(c) for c in points] for g in (p, q, w)]
    expected = sum(s * area @ (x * y * z) for s, x, y, z in zip(share, *at, strict=True))
    assert np.isclose(p @ weighted_mass(MESH, w) @ q, expected)


def test_stiffness_matrix_is_libigls_cotangent_matrix():
    assert np.abs(stiffness(MESH) + igl.cotmatrix(MESH.unit, F)).max() < 1e-12


def test_eigenpairs_are_those_of_a_dense_solver():
    projection = ism.weighted_eigen_projection(MESH.v, F, X)
    B = weighted_mass(MESH, ism.conformal_factor(MESH.v, F, X)).toarray()
    A = stiffness(MESH).toarray()
    assert np.allclose(projection.eigenvalues, eigh(A, B)[0][1:4])
    assert np.allclose(projection.phi.T @ B @ projection.phi, np.eye(3), atol=1e-9)  # eq. (16)
    residual = A @ projection.phi
    span = np.linalg.lstsq(B @ projection.phi, residual, rcond=None)[0]
    assert np.abs(B @ projection.phi @ span - residual).max() < 1e-8


@pytest.mark.parametrize("c", [[0, 0, 0], [0.3, 0.2, -0.4]])
def test_a_conformal_map_has_eigenvalues_two_and_a_round_phi(c):
    """Theorem 2: phi_1^2 + phi_2^2 + phi_3^2 = 3 / (4 pi), and the star map is the map."""
    x, f = icosphere(4)
    y = moebius(x, c)
    projection = ism.weighted_eigen_projection(x, f, y)
    assert np.allclose(projection.eigenvalues, 2, atol=0.05)
    assert np.allclose((projection.phi**2).sum(axis=1), 3 / (4 * np.pi), rtol=0.05)
    assert ism.certify(projection.star_map, f).folding_free
    if not any(c):
        assert np.allclose(projection.star_map, y, atol=0.02)


def test_eigenvalues_converge_at_second_order():
    errors = []
    for level in (2, 3, 4):
        x, f = icosphere(level)
        errors.append(np.abs(ism.weighted_eigen_projection(x, f, x).eigenvalues - 2).max())
    assert np.allclose(np.array(errors[:-1]) / errors[1:], 4, rtol=0.15)


def test_the_smallest_mesh_has_a_star_map():
    v = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    f = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
    found = ism.weighted_eigen_projection(v, f, ism.gauss_map(v, f))
    assert ism.certify(found.star_map, f).folding_free
    assert found.phi.shape == found.star_map.shape == (4, 3)
    assert found.eigenvalues.shape == (3,)
    assert np.ptp(found.eigenvalues) < 1e-9 * found.eigenvalues[0]  # by symmetry
    octahedron = np.vstack((np.eye(3), -np.eye(3)))
    faces = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    # below the size for Lanczos, and above
    for x, g in ((octahedron, faces), ism.samples.sphere(12)):
        found = ism.weighted_eigen_projection(x, g, x)
        assert found.phi.shape == x.shape
        assert found.eigenvalues.shape == (3,)
        assert np.allclose(found.star_map, x, atol=1e-9)


def test_two_runs_agree_bit_for_bit():
    one, two = (ism.weighted_eigen_projection(MESH.v, F, X) for _ in range(2))
    assert np.array_equal(one.phi, two.phi)


def test_the_conformal_factor_is_made_finite_and_positive():
    """A vertex without source area has the largest finite value, one without image the least; all others their own."""
    v, x = X.copy(), X.copy()
    hidden, crushed = (np.unique(F[(vertex == F).any(axis=1)]) for vertex in (0, 400))
    assert not np.isin(hidden, crushed).any()
    v[hidden], x[crushed] = X[0], X[400]
    mesh = ism.check_mesh(v, F)
    factor, changed = finite_conformal_factor(mesh, x)
    image, source = vertex_areas(x, F), vertex_areas(mesh.unit, F)
    own = np.ones(len(X), bool)
    own[[0, 400]] = False
    assert changed == 2
    assert np.allclose(factor[own], image[own] / source[own])
    assert factor[0] == factor[own].max()
    assert 0 < factor[400] < 1e-9 * factor[own].min()


def test_images_that_are_no_numbers_are_refused():
    x = X.copy()
    x[3] = np.nan
    with pytest.raises(ism.MeshError, match=r"images .* e\.g\. 3;"):
        ism.weighted_eigen_projection(X, F, x)


@pytest.mark.parametrize("mirrored", [1, -1])
def test_eigenfunctions_are_turned_to_agree_best_with_the_map(mirrored):
    """Of all turns that leave the star map as it faces; the mirror image of a map is met as well as it can be."""
    x = moebius(X, [0.3, 0.2, -0.1]) * [1, 1, mirrored]
    found = ism.weighted_eigen_projection(MESH.v, F, x)
    M = found.phi.T @ weighted_mass(MESH, ism.conformal_factor(MESH.v, F, x)) @ x
    first, second, third = np.linalg.svd(M, compute_uv=False)
    assert np.allclose(M, M.T, atol=1e-9 * first)
    assert np.trace(M) == pytest.approx(first + second + mirrored * third)


def test_star_maps_are_never_inside_out():
    """The mirror image of a map has its conformal factor; half of a bad map is its own mirror image."""
    x, f = icosphere(3)
    v = x * [1, 1.3, 2]
    conformal = ism.spherical_conformal_map(v, f).sphere
    for weights in (conformal, conformal * [1, 1, -1], np.abs(conformal)):
        star = ism.weighted_eigen_projection(v, f, weights).star_map
        assert ism.certify(star, f).folding_free


def test_star_maps_of_star_maps_approach_a_conformal_map_without_foldings():
    mesh = ism.check_mesh(*ism.samples.make("dino", n_vertices=1500))
    energy = HarmonicEnergy.of(mesh, "delaunay")
    problem, x, energies = (
        Problem.of(mesh, energy, l2_metric(mesh)),
        vertex_normals(mesh.unit, mesh.f),
        [],
    )
    assert folded_faces(x, mesh.f).mean() > 0.2
    for _ in range(8):
        x = problem.centred(project(mesh, energy.L, x).star_map)
        energies.append(energy.evaluate(x)[0])
    assert not folded_faces(x, mesh.f).any()
    assert abs(energies[-1] - energies[-2]) < 1e-3 * energies[-1]
    assert energies[-1] < 1.01 * 4 * np.pi


def test_gauss_map_is_libigls_area_weighted_normal():
    v = X * [1, 1.3, 2]
    normals = igl.per_vertex_normals(v, F, igl.PER_VERTEX_NORMALS_WEIGHTING_TYPE_AREA)
    assert np.allclose(ism.gauss_map(v, F), normals)  # Definition 1


def test_gauss_map_of_a_spheroid_is_its_exact_normal_in_the_limit():
    errors = []
    for level in (3, 4):
        x, f = icosphere(level)
        exact = x / [1, 1, 2]
        exact /= np.linalg.norm(exact, axis=1)[:, None]
        errors.append(np.sqrt(((ism.gauss_map(x * [1, 1, 2], f) - exact) ** 2).sum(1).mean()))
    assert errors[0] / errors[1] > 2


def test_gauss_map_of_an_inside_out_mesh_points_inward():
    assert np.allclose(ism.gauss_map(X, F[:, ::-1]), -ism.gauss_map(X, F))


def test_every_vertex_has_a_direction_even_where_faces_have_no_area():
    v = X.copy()
    v[X[:, 2] > 0.7] = [0, 0, 1]
    normals = ism.gauss_map(v, F)
    assert np.allclose(np.linalg.norm(normals, axis=1), 1)


def test_projections_without_weight_end_with_the_first_that_moves_less_than_half_a_radian():
    mesh = ism.check_mesh(*ism.samples.dumbbell(n_vertices=300))
    A, full = -igl.cotmatrix(mesh.v, mesh.f), igl.MASSMATRIX_TYPE_FULL
    gauss_map = vertex_normals(mesh.unit, mesh.f)
    x = project(mesh, A, gauss_map, igl.massmatrix(mesh.unit, mesh.f, full)).star_map
    moved = np.inf
    while moved > 0.5:
        before, x = x, project(mesh, A, x, igl.massmatrix(x, mesh.f, full)).star_map
        areas = vertex_areas(x, mesh.f)
        moved = np.sqrt(np.average(((x - before) ** 2).sum(axis=1), weights=areas))
    found = project_unweighted(mesh, A, gauss_map, lambda y: y)
    np.testing.assert_allclose(found.star_map, x, rtol=0, atol=1e-9)
    assert found.floored == 0  # no weight, none raised


def test_starts_are_iterates_before_the_first_step():
    iterates = []
    ism.spherical_conformal_map(
        *ism.samples.make("dino", n_vertices=1500), method="lai2014", listener=iterates.append
    )
    starts = [entry.iteration for entry in iterates if entry.stage in ("gauss map", "star map")]
    assert starts == [0] * len(starts)
    assert len(starts) == 2
