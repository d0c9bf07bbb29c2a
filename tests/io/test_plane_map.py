"""Maps to the plane in files, of this package and of others."""

import importlib.util

import numpy as np
import pytest
from disks import half
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.io.patch import read_patch

W, G, ROWS = half(*icosphere(3))
FLAT = ism.flatten(W, G)


@pytest.mark.parametrize("name", ["a.obj", "a.npz", "a.ply", "a.off", "a.vtk", "lh.a.patch.flat", "lh.a.surf.gii"])
def test_a_map_comes_back_and_is_certified_as_written(tmp_path, name):
    if name.endswith(".gii") and importlib.util.find_spec("nibabel") is None:
        pytest.skip("needs nibabel")
    certificate = ism.write_plane_map(tmp_path / name, FLAT)
    assert certificate.folding_free
    again = ism.read_plane_map(tmp_path / name, surface=None if name in ("a.obj", "a.npz") else (W, G))
    assert again.certificate.folding_free
    assert (again.rim == FLAT.rim).all()
    error = np.abs(again.plane - FLAT.plane).max()
    assert error == 0 if name in ("a.obj", "a.npz", "a.ply", "a.off", "a.vtk") else error < 1e-6
    with pytest.raises(ism.FileError):
        ism.write_plane_map(tmp_path / name, FLAT)


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
    again = ism.read_plane_map(tmp_path / "lh.a.patch.flat", surface=icosphere(3))  # what it was cut from
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


@pytest.mark.parametrize(("face", "words"), [
    ("f 1/1/1 2/2/1 3/3/1", None),
    ("f 1/1 2/2 3/4", None),
    ("f 1/1 2/2 3/3\nf 1/4 2/2 3/3", "seams"),
    ("f 1 2 3", "without texture"),
    ("f 1/1 2/2 3/9", "a.obj"),
    ("f -3/1 -2/2 -1/3", "negative"),
])
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
