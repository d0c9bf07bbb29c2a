"""Angles, areas and volumes against exact values and identities."""

import igl
import numpy as np
import pytest
from triangulations import icosphere, unit

from igl_spheremap.mesh.measure import (
    angle_defects,
    corner_angles,
    enclosed_volume,
    face_areas,
    fill_directions,
    log_edges,
    vertex_areas,
)

X, F = icosphere(3)
V = X * [1, 1.3, 2]


def test_angles_are_libigls_and_sum_to_pi():
    angles = corner_angles(V, F)
    assert np.allclose(angles, igl.internal_angles(V, F))
    assert np.allclose(angles.sum(axis=1), np.pi)


def test_angles_of_degenerate_faces_are_finite_and_right():
    v = np.array(
        [[0, 0, 0], [1, 0, 0], [2, 0, 0], [1e-9, 1e-9, 0], [0, 0, 0], [0.5, 1e-12, 0]], dtype=float
    )
    angles = np.degrees(corner_angles(v, np.array([[0, 1, 2], [0, 4, 1], [0, 1, 5]])))
    assert np.isfinite(angles).all()
    assert np.allclose(angles[0], [0, 180, 0])
    assert np.allclose(angles[2], [0, 0, 180], atol=1e-6)


def test_tiny_images_keep_their_angles():
    tiny = unit(np.array([0, 0, 1.0]) + 1e-11 * V)
    assert np.abs(corner_angles(tiny, F) - corner_angles(V * [1, 1, 0], F)).mean() < 1e-3


def test_angle_defects_sum_to_two_pi_times_the_characteristic():
    assert np.isclose(angle_defects(corner_angles(V, F), F, len(V)).sum(), 4 * np.pi)
    plane = angle_defects(
        corner_angles(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]]), F[:0]), F[:0], 3
    )
    assert np.allclose(plane, 2 * np.pi)


@pytest.mark.parametrize("exponent", [0, -60, -75, -80, -100, -150])
def test_areas_are_right_as_long_as_float64_holds_them(exponent):
    """Images of the deepest limbs are so small at ends of axes."""
    triangle = np.array([[0, 0, 0], [1, 0, 0], [0.3, 0.8, 0]]) * 10.0**exponent
    assert face_areas(triangle, np.array([[0, 1, 2]])) == pytest.approx(
        0.4 * 10.0 ** (2 * exponent), rel=1e-12, abs=0
    )
    assert face_areas(triangle, np.array([[0, 1, 1], [0, 0, 0]])).tolist() == [0, 0]


def test_vertex_areas_are_the_barycentric_mass():
    mass = igl.massmatrix(V, F, igl.MASSMATRIX_TYPE_BARYCENTRIC).diagonal()
    assert np.allclose(vertex_areas(V, F), mass, rtol=1e-13)


def test_volume_is_signed_and_does_not_depend_on_the_origin():
    cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = np.array(
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    )
    f = np.vstack((quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]))
    for shift in (0, 1e3):
        assert enclosed_volume(2 * cube + shift, f) == pytest.approx(8)
        assert enclosed_volume(2 * cube + shift, f[:, ::-1]) == pytest.approx(-8)


def test_log_edges_of_a_regular_solid_and_of_none():
    tetrahedron = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    f = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    assert np.allclose(log_edges(tetrahedron, f), np.log(np.sqrt(8)))
    assert np.allclose(log_edges(1e-290 * tetrahedron, f), np.log(np.sqrt(8)) - 290 * np.log(10))
    assert np.allclose(log_edges(0 * tetrahedron, f), np.log(np.finfo(float).tiny))


def test_missing_directions_are_filled_ring_by_ring():
    x = np.where(X[:, [2]] > 0, 0.0, X)
    filled = fill_directions(x, F)
    assert np.allclose(np.linalg.norm(filled, axis=1), 1)
    known = X[:, 2] <= 0
    assert np.allclose(filled[known], X[known])
    assert np.allclose(np.linalg.norm(fill_directions(np.full_like(X, np.nan), F), axis=1), 1)
