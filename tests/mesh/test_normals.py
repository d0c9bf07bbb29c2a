"""The Gauss map: libigl's normals, and a direction for every vertex."""

import igl
import numpy as np
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.mesh.normals import fill_directions

X, F = icosphere(3)


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


def test_missing_directions_are_filled_ring_by_ring():
    x = np.where(X[:, [2]] > 0, 0.0, X)
    filled = fill_directions(x, F)
    assert np.allclose(np.linalg.norm(filled, axis=1), 1)
    known = X[:, 2] <= 0
    assert np.allclose(filled[known], X[known])
    assert np.allclose(np.linalg.norm(fill_directions(np.full_like(X, np.nan), F), axis=1), 1)
