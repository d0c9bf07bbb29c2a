"""Maps to the plane in files, of this package and of others."""

import importlib.util

import numpy as np
import pytest
from disks import half
from triangulations import icosphere

import igl_spheremap as ism

W, G, ROWS = half(*icosphere(3))
FLAT = ism.flatten(W, G)


@pytest.mark.parametrize("name", ["a.obj", "a.npz", "a.ply", "a.off", "a.vtk", "lh.a.patch.flat", "lh.a.surf.gii"])
def test_a_map_comes_back_and_is_certified_as_written(tmp_path, name):
    if name.endswith(".gii") and importlib.util.find_spec("nibabel") is None:
        pytest.skip("needs nibabel")
    certificate = ism.write_plane_map(tmp_path / name, FLAT)
    assert certificate.folding_free
    p = ism.read_plane_map(tmp_path / name)
    error = np.abs(p - FLAT.plane).max()
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
    patch = ism.read_patch(tmp_path / "lh.a.patch.flat")
    assert (patch.rows == ROWS).all()
    assert patch.border.sum() == len(FLAT.rim)


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
        assert ism.read_plane_map(path).shape == (3, 2)
    else:
        with pytest.raises(ism.MeshError, match=words):
            ism.read_plane_map(path)


def test_what_holds_no_plane_map_is_refused(tmp_path):
    for name in ("a.ply", "a.obj", "a.npz"):
        ism.write_mesh(tmp_path / name, W, G)
        with pytest.raises(ism.MeshError, match="no map to the plane"):
            ism.read_plane_map(tmp_path / name)
