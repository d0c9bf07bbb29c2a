"""Mesh objects in the place of `v, f`, and options that a function does not have."""

from __future__ import annotations

import inspect
from pathlib import Path
from types import SimpleNamespace

import igl
import numpy as np
import pytest
from doors import PUBLIC

import igl_spheremap as ism

V, F = ism.samples.make("spheroid", n_vertices=300)
#: meshio.Mesh, as far as it is looked at; other packages' meshes are made by themselves below.
MESHIO = SimpleNamespace(points=V, cells_dict={"line": F[:, :2], "triangle": F})


def of_trimesh():
    return pytest.importorskip("trimesh").Trimesh(V, F, process=False)


def of_pyvista():
    return pytest.importorskip("pyvista").PolyData.from_regular_faces(V, F)


def of_nibabel():
    gifti = pytest.importorskip("nibabel.gifti")
    arrays = (V, "POINTSET", "FLOAT64"), (F.astype(np.int32), "TRIANGLE", "INT32")
    return gifti.GiftiImage(
        darrays=[
            gifti.GiftiDataArray(array, f"NIFTI_INTENT_{intent}", f"NIFTI_TYPE_{kind}")
            for array, intent, kind in arrays
        ]
    )


def of_nilearn():
    return pytest.importorskip("nilearn.surface").InMemoryMesh(V, F)


def with_parts():
    return pytest.importorskip("nilearn.surface").PolyMesh(left=of_nilearn())


def of_lapy():
    return pytest.importorskip("lapy").TriaMesh(V, F)


def scene():
    return pytest.importorskip("trimesh").Scene([of_trimesh()])


def grid():
    return of_pyvista().cast_to_unstructured_grid()


def as_read():
    return ism.read_mesh("sample:spheroid:n_vertices=300")


@pytest.mark.parametrize(
    "make",
    [
        of_trimesh,
        of_pyvista,
        as_read,
        lambda: MESHIO,
        lambda: (V, F),
        lambda: [V.tolist(), F.tolist()],
        lambda: ism.check_mesh(V, F),
        lambda: ism.repair_mesh(V, F),
        lambda: (V, F, V[:, 0]),
        lambda: readobj(V, F),
        of_nibabel,
        of_nilearn,
        with_parts,
        of_lapy,
        scene,
        grid,
    ],
    ids=[
        "trimesh",
        "PyVista",
        "read_mesh",
        "meshio",
        "pair",
        "lists",
        "check_mesh",
        "repair_mesh",
        "napari",
        "readOBJ",
        "nibabel",
        "nilearn",
        "PolyMesh",
        "LaPy",
        "scene",
        "grid",
    ],
)
def test_a_mesh_object_stands_for_its_arrays(make, tmp_path):
    mesh = make()
    assert np.array_equal(ism.check_mesh(mesh).v, V)
    assert np.array_equal(ism.gauss_map(mesh), ism.gauss_map(V, F))
    assert np.array_equal(ism.angle_differences(mesh, 2 * V), ism.angle_differences(V, F, 2 * V))
    assert ism.harmonic_energy(v=mesh, x=V) == ism.harmonic_energy(V, F, V)
    assert (
        ism.certify(mesh, F).foldings == ism.certify(V, mesh).foldings == ism.certify(V, F).foldings
    )
    ism.write_mesh(tmp_path / "a.obj", mesh)
    assert np.array_equal(ism.read_mesh(tmp_path / "a.obj").f, F)


def readobj(v, f):
    """The result of igl.readOBJ: positions, texture coordinates and normals, and the faces of each."""
    return v, np.empty((0, 2)), v, f, np.empty((0, 3), int), f


def test_what_a_reader_returns_stands_for_its_mesh(tmp_path):
    igl.writeOBJ(str(tmp_path / "a.obj"), V, F)
    for given in (igl.readOBJ(str(tmp_path / "a.obj")), readobj(V, F), (V, F, V[:, 0])):
        assert np.allclose(ism.gauss_map(*given), ism.gauss_map(V, F))
    with pytest.raises(TypeError, match="positional arguments"):
        ism.gauss_map(V, F, F)


def test_a_map_is_an_array_of_its_images():
    result = ism.spherical_conformal_map(V, F)
    assert np.asarray(result).shape == (len(V), 3)
    assert np.array_equal(igl.doublearea(np.asarray(result), F), igl.doublearea(result.sphere, F))
    assert np.asarray(result, np.float32).dtype == np.float32
    assert np.array(result, copy=True).flags.writeable
    cap = F[(V[F, 2] > 0).all(axis=1)]
    disk = ism.disk_conformal_map(*igl.remove_unreferenced(V, cap)[:2])
    assert np.array_equal(disk, disk.plane)


def test_every_public_function_of_v_and_f_takes_a_mesh_object():
    for one in PUBLIC.values():
        if inspect.isfunction(one) and list(inspect.signature(one).parameters)[:2] == ["v", "f"]:
            with pytest.raises(ism.FileError, match=r"bunny\.obj"):
                one("bunny.obj")
    with pytest.raises(ism.FileError, match=r"bunny\.obj"):
        ism.SphereMapper("bunny.obj")


def test_the_name_of_a_file_stands_for_its_mesh_and_where_a_sphere_is_meant_for_its_sphere(
    tmp_path,
):
    result = ism.spherical_conformal_map(V, F)
    for name in ("map.npz", "sphere.ply"):
        ism.write_map(tmp_path / name, result)
        assert ism.certify(tmp_path / name).folding_free
        assert ism.certify(str(tmp_path / name)).degree == 1
    repaired = ism.repair_mesh(V, F[5:], holes="fill")
    ism.write_map(tmp_path / "caps.npz", ism.spherical_conformal_map(repaired))
    assert np.array_equal(ism.check_mesh(tmp_path / "caps.npz").caps, repaired.caps)
    assert np.array_equal(ism.gauss_map(str(tmp_path / "map.npz")), ism.gauss_map(V, F))


def test_the_caps_of_a_mesh_come_with_it():
    repaired = ism.repair_mesh(V, F[5:], holes="fill")
    assert np.array_equal(ism.check_mesh(repaired).caps, repaired.face_source < 0)
    assert ism.check_mesh(repaired, caps=np.arange(len(repaired.f)) == 0).caps.sum() == 1
    assert np.array_equal(ism.SphereMapper(repaired).mesh.caps, repaired.caps)
    assert ism.repair_mesh(V, F).caps is None


@pytest.mark.parametrize(
    ("mesh", "error", "words"),
    [
        (Path("bunny.obj"), ism.FileError, "bunny.obj: No such file"),
        (
            SimpleNamespace(points=V, cells_dict={"tetra": F}),
            ism.MeshError,
            r"not triangles alone \(\d+ of type tetra\)",
        ),
        (
            SimpleNamespace(points=V, cells_dict={"triangle": F, "quad": F}),
            ism.MeshError,
            "triangles alone",
        ),
        (
            V,
            TypeError,
            "ndarray is given without faces; give vertices and faces, the name of a file, or a mesh of trimesh",
        ),
        ({"v": V, "f": F}, TypeError, "dict is given without faces"),
        (
            SimpleNamespace(parts={"left": 0, "right": 1}),
            ism.MeshError,
            r"the parts left, right; .* parts\['left'\]",
        ),
        (
            SimpleNamespace(agg_data=lambda intents: (V, ())),
            ism.MeshError,
            "one array of points and one of triangles",
        ),
        (
            SimpleNamespace(vertices=V, faces=F, sphere=V),
            ism.MeshError,
            "give its vertices, its faces or its sphere",
        ),
    ],
)
def test_what_is_not_a_mesh_is_refused_in_a_sentence(mesh, error, words):
    with pytest.raises(error, match=words):
        ism.check_mesh(mesh)


def test_polygons_of_pyvista_are_refused():
    with pytest.raises(ism.MeshError, match="triangulate"):
        ism.check_mesh(pytest.importorskip("pyvista").Cube())


@pytest.mark.parametrize(
    ("function", "option", "words"),
    [
        ("spherical_conformal_map", "max_iteration", "did you mean max_iterations?"),
        ("flatten", "method", "it takes v, f, caps, balance, listener"),
    ],
)
def test_an_option_that_a_call_lacks_is_refused_with_its_name(function, option, words):
    with pytest.raises(TypeError, match=f"^{function} takes no {option}; {words}"):
        getattr(ism, function)(V, F, **{option: 1})


def test_a_map_in_the_wrong_place_is_named(tmp_path):
    result = ism.spherical_conformal_map(V, F)
    made = r"; give a SphereMap, as balanced_spherical_map\(v, f\) makes one, and sphere_map\(v, f, x\) of positions x"
    with pytest.raises(TypeError, match=f"^result is .*{made}"):
        ism.write_map(tmp_path / "x.obj", result.sphere)
    with pytest.raises(TypeError, match=r"^path is SphereMap.*; give the name of a file"):
        ism.write_map(result, tmp_path / "x.obj")
    with pytest.raises(TypeError, match=f"^source is .*{made}"):
        ism.shapes.register(V, F)
