"""Measures of a mesh against libigl by another path than the package's own."""

import igl
import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.mesh.measure import angle_defects, corner_angles, enclosed_volume, face_areas
from igl_spheremap.operators.flips import delaunay_triangulation
from igl_spheremap.operators.laplacian import mollified_edge_lengths


@pytest.fixture(scope="module", params=["dino", "bird", "octopus"])
def mesh(request):
    return ism.check_mesh(*ism.samples.make(request.param, n_vertices=1500))


def test_angle_defects_are_libigls_gaussian_curvature(mesh):
    defects = angle_defects(corner_angles(mesh.unit, mesh.f), mesh.f, len(mesh.v))
    assert np.allclose(defects, igl.gaussian_curvature(mesh.unit, mesh.f), atol=1e-12)
    assert defects.sum() == pytest.approx(4 * np.pi)


def test_the_volume_is_libigls_moment(mesh):
    assert enclosed_volume(mesh.unit, mesh.f) == pytest.approx(
        float(igl.moments(mesh.unit, mesh.f)[0]), rel=1e-12
    )


def test_areas_are_those_of_cross_products(mesh):
    a, b, c = mesh.unit[mesh.f].transpose(1, 0, 2)
    assert np.allclose(
        face_areas(mesh.unit, mesh.f), np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    )


def test_row_sums_of_the_full_mass_are_the_barycentric_one(mesh):
    full = igl.massmatrix(mesh.unit, mesh.f, igl.MASSMATRIX_TYPE_FULL)
    lumped = igl.massmatrix(mesh.unit, mesh.f, igl.MASSMATRIX_TYPE_BARYCENTRIC).diagonal()
    assert np.allclose(np.asarray(full.sum(axis=1)).ravel(), lumped, rtol=1e-12)


def test_the_gauss_map_is_the_sum_of_area_normals(mesh):
    a, b, c = mesh.unit[mesh.f].transpose(1, 0, 2)
    sums = np.zeros_like(mesh.unit)
    for corner in mesh.f.T:
        np.add.at(sums, corner, np.cross(b - a, c - a))
    sums /= np.linalg.norm(sums, axis=1, keepdims=True)
    assert np.allclose(ism.gauss_map(mesh.v, mesh.f), sums, atol=1e-12)
    angle = igl.PER_VERTEX_NORMALS_WEIGHTING_TYPE_ANGLE
    assert not np.allclose(sums, igl.per_vertex_normals(mesh.unit, mesh.f, angle), atol=1e-3)


def test_own_flips_end_at_an_intrinsic_delaunay_triangulation_by_libigl(mesh):
    lengths, faces = delaunay_triangulation(mollified_edge_lengths(mesh.unit, mesh.f), mesh.edges)[
        :2
    ]
    assert np.asarray(igl.is_intrinsic_delaunay(lengths, faces)).all()
