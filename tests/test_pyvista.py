"""PyVista's meshes are mapped, balanced, certified and drawn; all but closed triangle meshes are refused."""

import doctest

import numpy as np
import pytest

import igl_spheremap as ism

pv = pytest.importorskip("pyvista", minversion="0.48")
ours = pytest.importorskip("igl_spheremap.pyvista")


@pytest.fixture
def mesh():
    mesh = pv.PolyData.from_regular_faces(*ism.samples.make("pear", n_vertices=900))
    mesh["height"] = mesh.points[:, 2]
    return mesh


def arrays(mesh):
    return mesh.points, mesh.regular_faces


def test_its_examples_run():
    assert doctest.testmod(ours) == doctest.TestResults(failed=0, attempted=6)


def test_the_sphere_is_that_of_the_arrays_with_the_data_of_the_mesh(mesh):
    sphere, result = mesh.spheremap.map(), ism.spherical_conformal_map(*arrays(mesh))
    assert sphere.points.dtype == np.float64
    assert np.array_equal(sphere.points, result.sphere)
    assert np.array_equal(sphere.regular_faces, mesh.regular_faces)
    assert np.array_equal(sphere["height"], mesh.points[:, 2])
    assert np.array_equal(sphere.cell_data[ours.AREAS], result.log_area_ratios())
    assert np.array_equal(sphere.point_data[ours.FACTOR], result.conformal_factor())
    assert sphere.spheremap.result.certificate.folding_free
    assert ours.AREAS not in mesh.cell_data


def test_balance_goes_from_angles_to_areas(mesh):
    kept = [
        np.abs(mesh.spheremap.balance(balance).cell_data[ours.AREAS]).mean()
        for balance in (0, 0.5, 1)
    ]
    assert kept[0] > kept[1] > kept[2]
    assert kept[2] < 0.1 * kept[0]


def test_a_planted_fold_is_found(mesh):
    sphere = mesh.spheremap.map()
    assert ism.certify(sphere).folding_free
    sphere.points[sphere.regular_faces[7]] *= -1
    found = ism.certify(sphere, mesh)
    assert 7 in found.flipped
    assert str(found) == str(ism.certify(*arrays(sphere)))


def test_single_precision_and_the_order_of_points_are_kept(mesh):
    single = pv.PolyData.from_regular_faces(mesh.points.astype(np.float32), mesh.regular_faces)
    assert np.allclose(single.spheremap.map().points, mesh.spheremap.map().points, atol=1e-4)


@pytest.mark.parametrize(("make", "words"), [
    (lambda: pv.Cube(), "not triangles; call triangulate"),
    (lambda: pv.Sphere().clip(), "triangles|open surface"),
    (lambda: pv.ParametricTorus().triangulate().clean(), "genus|torus|handle"),
])  # fmt: skip
def test_what_is_no_closed_genus_0_mesh_is_refused(make, words):
    with pytest.raises(ism.MeshError, match=words):
        make().spheremap.map()
