"""Maps to the plane in files, of this package and of others."""

import json

import numpy as np
import pytest
from disks import half
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.io.patch import read_patch
from igl_spheremap.plane.plane_map import unit_square

W, G, ROWS = half(*icosphere(3))
FLAT = ism.flatten(W, G)


@pytest.mark.parametrize(
    "name",
    ["a.obj", "a.glb", "a.npz", "a.ply", "a.off", "a.vtk", "lh.a.patch.flat", "lh.a.surf.gii"],
)
def test_a_map_comes_back_and_is_certified_as_written(tmp_path, name):
    for suffix, package in ((".gii", "nibabel"), (".glb", "trimesh")):
        if name.endswith(suffix):
            pytest.importorskip(package)
    certificate = ism.write_plane_map(tmp_path / name, FLAT)
    assert certificate.folding_free
    again = ism.read_plane_map(
        tmp_path / name, surface=None if name in ("a.obj", "a.glb", "a.npz") else (W, G)
    )
    assert again.certificate.folding_free
    assert (again.rim == FLAT.rim).all()
    plane = again.plane
    if name in ("a.obj", "a.glb"):
        assert (plane.min(), plane.max()) == (0, 1)
        _, known = unit_square(FLAT.plane)
        plane = plane / known["factor"] + known["corner"]
    error = np.abs(plane - FLAT.plane).max()
    assert error == 0 if name in ("a.npz", "a.ply", "a.off", "a.vtk") else error < 1e-6
    with pytest.raises(ism.FileError):
        ism.write_plane_map(tmp_path / name, FLAT)


def test_other_programs_read_the_coordinates_and_the_factor(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    for name, up in (("a.obj", "y"), ("a.glb", "z")):
        ism.write_plane_map(tmp_path / name, FLAT, up=up)
    first = (tmp_path / "a.obj").read_text().partition("\n")[0]
    known = json.loads(first.removeprefix("# vt: "))
    theirs = trimesh.load_mesh(tmp_path / "a.obj", process=False, maintain_order=True)
    assert np.allclose(
        theirs.visual.uv, known["factor"] * (FLAT.plane - known["corner"]), atol=1e-12
    )
    scene = trimesh.load_scene(tmp_path / "a.glb", process=False)
    (part,) = scene.geometry.values()
    assert part.metadata["factor"] == known["factor"]
    assert np.allclose(part.visual.uv, theirs.visual.uv, atol=1e-6)
    assert part.visual.material.baseColorTexture.size == (1024, 1024)
    turned = scene.to_mesh().vertices  # y is up there, by the standard
    assert np.allclose(turned, W[:, [0, 2, 1]] * [1, 1, -1], atol=1e-6)


def test_a_seam_has_each_vertex_once_and_coordinates_by_corner(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    v, f = icosphere(2)
    disk = ism.repair_disk(v, f, cut=3)
    flat = ism.flatten(disk)
    assert ism.write_plane_map(tmp_path / "a.obj", flat, rows=disk.vertex_source).folding_free
    again = ism.read_mesh(tmp_path / "a.obj")
    assert np.array_equal(again.v, v)
    assert np.array_equal(again.f, f)
    assert np.array_equal(ism.read_plane_map(tmp_path / "a.obj").plane, unit_square(flat.plane)[0])
    # doubles vertices where coordinates differ
    theirs = trimesh.load_mesh(tmp_path / "a.obj", process=False)
    assert len(theirs.vertices) == len(disk.v)
    certificate = ism.certify(np.asarray(theirs.visual.uv), theirs.faces)
    assert certificate.folding_free
    with pytest.raises(ism.FileError, match="each once"):
        ism.write_plane_map(tmp_path / "lh.a.patch.flat", flat, rows=disk.vertex_source)
    # in any order
    assert ism.write_plane_map(tmp_path / "b.obj", FLAT, rows=ROWS[::-1]).folding_free
    assert np.array_equal(ism.read_mesh(tmp_path / "b.obj").v, W)
    ism.write_plane_map(tmp_path / "a.npz", flat, rows=disk.vertex_source)
    assert np.array_equal(np.load(tmp_path / "a.npz")["vertex_source"], disk.vertex_source)


def test_caps_are_a_group_of_their_own_and_stay_caps(tmp_path):
    holes = ism.repair_disk(W, np.delete(G, 60, axis=0), holes="fill")
    flat = ism.flatten(holes)
    assert flat.angle_differences().shape == (len(G) - 1, 3)
    for name in ("a.obj", "a.npz"):
        assert ism.write_plane_map(tmp_path / name, flat, rows=holes.vertex_source).folding_free
    assert (tmp_path / "a.obj").read_text().partition("g caps\n")[2].count("f ") == 1
    assert ism.read_plane_map(tmp_path / "a.npz").mesh.caps.sum() == 1


def test_an_obj_file_holds_the_surface_too(tmp_path):
    ism.write_plane_map(tmp_path / "a.obj", FLAT)
    v, f = ism.read_mesh(tmp_path / "a.obj")
    assert (v == W).all()
    assert (f == G).all()


def test_patches_number_the_whole_surface(tmp_path):
    ism.write_plane_map(tmp_path / "lh.a.patch.flat", FLAT, rows=ROWS)
    patch = read_patch(tmp_path / "lh.a.patch.flat")
    assert (patch.rows == ROWS).all()
    assert patch.border.sum() == len(FLAT.rim)
    # what it was cut from
    again = ism.read_plane_map(tmp_path / "lh.a.patch.flat", surface=icosphere(3))
    assert again.certificate.folding_free
    assert (again.faces == G).all()
    assert np.abs(again.angle_differences() - FLAT.angle_differences()).max() < 1e-3


def test_a_map_that_folds_says_so_when_it_is_read(tmp_path):
    p = FLAT.plane.copy()
    inner = np.setdiff1d(np.arange(len(p)), FLAT.rim)[0]
    p[inner] = p[FLAT.rim[0]] * 2
    np.savez(tmp_path / "a.npz", vertices=W, faces=G, plane=p)
    again = ism.read_plane_map(tmp_path / "a.npz")
    assert again.certificate.foldings > 0
    assert again.method == "given"


def test_an_image_alone_needs_its_surface(tmp_path):
    ism.write_plane_map(tmp_path / "a.ply", FLAT)
    with pytest.raises(ism.MeshError, match="surface=read_mesh"):
        ism.read_plane_map(tmp_path / "a.ply")
    with pytest.raises(ism.MeshError, match=f"has {len(W)} vertices but the surface has 3"):
        ism.read_plane_map(tmp_path / "a.ply", surface=(np.eye(3), [[0, 1, 2]]))


HEAD = "v 0 0 0\nv 1 0 0\nv 0 1 1\nvt 0 0\nvt 1 0\nvt 0 1\nvt 0.5 0.5\n"


@pytest.mark.parametrize(
    ("face", "words"),
    [
        ("f 1/1/1 2/2/1 3/3/1", None),
        ("f 1/1 2/2 3/4", None),
        ("f 1/1 2/2 3/3 3/4", "not triangles"),
        ("f 1 2 3", "without texture"),
        ("f 1/1 2/2 3/9", "a.obj"),
        ("f -3/1 -2/2 -1/3", "negative"),
    ],
)
def test_texture_coordinates_of_others(tmp_path, face, words):
    path = tmp_path / "a.obj"
    path.write_text(f"{HEAD}{face}\n")
    if words is None:
        assert ism.read_plane_map(path).plane.shape == (3, 2)
    else:
        with pytest.raises(ism.MeshError, match=words):
            ism.read_plane_map(path)


def test_what_holds_no_plane_map_is_refused(tmp_path):
    for name in ("a.ply", "a.obj", "a.npz"):
        ism.write_mesh(tmp_path / name, W, G)
        with pytest.raises(ism.MeshError, match="no map to the plane"):
            ism.read_plane_map(tmp_path / name)


def test_a_flat_mesh_of_a_part_goes_with_the_whole_surface(tmp_path):
    """As FreeSurfer's and HCP's flat maps: all vertices, of which those in no face lie anywhere."""
    v, f = ism.samples.sphere(642)
    part = f[(v[f][:, :, 2] > 0.2).all(axis=1)]
    used, corners = np.unique(part, return_inverse=True)
    flat = ism.flatten(v[used], corners.reshape(-1, 3))
    images = v.copy()
    images[used] = flat.image
    ism.write_mesh(tmp_path / "flat.ply", images, part)
    found = ism.read_plane_map(tmp_path / "flat.ply", surface=(v, f))
    assert np.array_equal(found.plane, flat.plane)
    assert np.array_equal(found.mesh.v, v[used])
    assert found.certificate.folding_free
    with pytest.raises(ism.MeshError, match="642 vertices but the surface has 12"):
        ism.read_plane_map(tmp_path / "flat.ply", surface=ism.samples.sphere(12))


def test_a_vertex_without_texture_coordinates_is_in_no_face(tmp_path):
    ism.write_plane_map(tmp_path / "flat.obj", FLAT)
    text = (tmp_path / "flat.obj").read_text()
    lines = [
        " ".join(f"{int(a) + 1}/{b}" for a, b in (corner.split("/") for corner in line.split()[1:]))
        for line in text.splitlines()
        if line.startswith("f ")
    ]
    head = [line for line in text.splitlines() if not line.startswith("f ")]
    (tmp_path / "more.obj").write_text(
        "\n".join(["v 9 9 9", *head, *(f"f {line}" for line in lines)]) + "\n"
    )
    found = ism.read_plane_map(tmp_path / "more.obj")
    assert np.array_equal(np.sort(found.mesh.v, axis=0), np.sort(FLAT.mesh.v, axis=0))
    assert found.certificate.folding_free


@pytest.mark.parametrize("rows", [object(), "abc", 3, [1, 2], np.full(len(FLAT.mesh.v), 0.5)])
def test_rows_that_are_no_number_of_each_vertex_are_refused(tmp_path, rows):
    with pytest.raises(ism.MeshError, match=r"^rows is .*; give a whole number for each"):
        ism.write_plane_map(tmp_path / "a.npz", FLAT, rows=rows)
    assert not list(tmp_path.iterdir())
