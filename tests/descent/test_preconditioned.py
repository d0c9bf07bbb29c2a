"""The fast map: the rest of each field on the sphere after a step, its estimate, and meshes too coarse for chords."""

from __future__ import annotations

import numpy as np
import pytest
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.descent.preconditioned import _boost, _correct_quadrupoles, harmonic_map
from igl_spheremap.mesh.check import check_mesh
from igl_spheremap.mesh.measure import face_areas
from igl_spheremap.operators.laplacian import build_operators
from igl_spheremap.sphere.moebius import fix_gauge
from igl_spheremap.sphere.rows import row_dots, tangent, unit_rows
from igl_spheremap.start.punctured import is_coarse, punctured_start
from igl_spheremap.verify.distortion import mean_angle_difference


def test_a_start_that_faces_cut_deep_through_is_kept_where_the_energy_misleads():
    """A square bar, each side but two triangles: the worse its chords, the less energy they have."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    v = np.vstack((corners, corners + np.array([0.0, 0.0, 8.0])))
    f = np.array(
        [[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]]
        + [
            face
            for a, b in ((0, 1), (1, 2), (2, 3), (3, 0))
            for face in ([a, b, b + 4], [a, b + 4, a + 4])
        ]
    )
    mesh = check_mesh(v, f)
    operators = build_operators(mesh)
    start = punctured_start(mesh, operators).x
    seen = []
    last = harmonic_map(mesh, operators, listener=lambda iterate: seen.append(iterate.x))[0].x
    assert is_coarse(face_areas(last, f).sum())
    mean = mean_angle_difference(mesh, last)
    assert mean == min(mean_angle_difference(mesh, x) for x in (seen[0], seen[-1]))
    assert np.abs(seen[0] - start).max() < 1e-9


def test_all_starts_lead_to_one_map():
    mesh = check_mesh(*ism.samples.make("spheroid", n_vertices=1500))
    operators = build_operators(mesh)
    starts = None, ism.gauss_map(mesh.v, mesh.f)
    plain, other = (
        fix_gauge(mesh, harmonic_map(mesh, operators, x, tolerance=1e-12)[0].x) for x in starts
    )
    assert np.abs(plain - other).max() < 1e-6


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize(("degree", "left"), [(2, 0), (3, 1 / 36), (4, 1 / 100)])
def test_a_step_leaves_nothing_of_degree_2_and_a_sixth_and_a_tenth_of_the_next_two(
    degree, left, turned
):
    """On the round sphere; of gradients of spherical harmonics, and of such gradients turned by a right angle."""
    x, f = icosphere(5)
    mesh = check_mesh(x, f)
    a, b, c = x.T
    gradients = {
        2: (b, a, 0 * c),
        3: (b * c, a * c, a * b),
        4: (3 * a**2 * b - b**3, a**3 - 3 * a * b**2, 0 * c),
    }
    field = tangent(x, np.column_stack(gradients[degree]))
    start = unit_rows(x + 1e-2 * (np.cross(x, field) if turned else field))
    energies = []
    harmonic_map(
        mesh,
        build_operators(mesh),
        start,
        tolerance=1e-9,
        listener=lambda step: energies.append(step.energy),
    )
    before, after = np.array(energies[:2]) - energies[-1]
    assert after / before == pytest.approx(left, rel=0.05, abs=1e-3)


@pytest.mark.parametrize("name", ["pear", "dino", "brain"])
def test_the_residual_is_about_the_energy_that_is_left(name):
    mesh = check_mesh(*ism.samples.make(name, n_vertices=5000))
    seen = []
    harmonic_map(mesh, build_operators(mesh), tolerance=1e-9, listener=seen.append)
    for iterate in seen[1:3]:
        left = (iterate.energy - seen[-1].energy) / (iterate.energy - iterate.details["area"])
        assert 0.5 * left < iterate.residual < 20 * left


def test_what_boosts_take_out_leaves_a_sum_of_zero():
    """In proportion to the density, whatever that, the map and the derivatives are."""
    rng = np.random.default_rng(0)
    x, H, density = unit_rows(rng.normal(size=(50, 3))), rng.normal(size=(50, 3)), rng.random(50)
    e = _boost(x, H, density)
    g = (
        tangent(x, H)
        + row_dots(x, H)[:, None] * x
        - density[:, None] * (x + e - x * (x @ e)[:, None])
    )
    assert np.abs(g.sum(axis=0)).max() < 1e-12


@pytest.mark.parametrize("share", [0.0, 0.6, 1.0])
def test_the_square_of_fields_of_degree_2_is_their_integral(share):
    """Of gradients of harmonics, of these turned by a right angle, and of sums of both."""
    x, f = icosphere(4)
    mesh = check_mesh(x, f)
    Q, other = np.array([[0, 1, 0], [1, 0, 2], [0, 2, 0.0]]), np.diag([1.0, 1, -2])
    field = (1 - share) * tangent(x, x @ Q) + share * np.cross(x, x @ other)
    g = 4 * np.pi * mesh.A[:, None] * field
    D = build_operators(mesh).factor.solve(g)
    square = _correct_quadrupoles(D, x, g)
    step = tangent(x, D)
    assert square == pytest.approx(4 * np.pi * mesh.A @ row_dots(step, step), rel=0.02)
