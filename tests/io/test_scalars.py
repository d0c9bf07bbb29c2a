"""Scalar maps over the vertices: what is written reads back, what is none is named."""

from __future__ import annotations

import numpy as np
import pytest

from igl_spheremap import FileError, MeshError
from igl_spheremap.io.files import write_mesh
from igl_spheremap.io.scalars import read_scalars, write_scalars
from igl_spheremap.samples import sphere
from igl_spheremap.verify.distortion import vertex_maps

VALUES = np.random.default_rng(0).normal(size=42)


@pytest.mark.parametrize(("name", "precision"), [("a.npz", 0), ("a.shape.gii", 1e-7), ("a.gii.gz", 1e-7)])
def test_maps_read_back_by_name(tmp_path, name, precision):
    if not name.endswith(".npz"):
        pytest.importorskip("nibabel")
    write_scalars(tmp_path / name, {"sulc": VALUES, "curv": -VALUES})
    maps = read_scalars(tmp_path / name)
    assert list(maps) == ["sulc", "curv"]
    assert np.abs(maps["sulc"] - VALUES).max() <= precision * np.abs(VALUES).max()


def test_freesurfer_files_are_named_by_their_ends(tmp_path):
    pytest.importorskip("nibabel")
    write_scalars(tmp_path / "lh.sulc", {"sulc": VALUES})
    assert np.allclose(read_scalars(tmp_path / "lh.sulc")["sulc"], VALUES, atol=1e-6)


def test_what_is_no_map_is_named(tmp_path):
    with pytest.raises(FileError, match="can't read"):
        read_scalars(tmp_path / "missing.npz")
    write_mesh(tmp_path / "mesh.npz", *sphere(42))
    with pytest.raises(MeshError, match="no scalar map"):
        read_scalars(tmp_path / "mesh.npz")
    (tmp_path / "damaged.npz").write_bytes(b"nothing")
    with pytest.raises(MeshError, match="damaged"):
        read_scalars(tmp_path / "damaged.npz")


def test_scalar_maps_in_other_programs(result, tmp_path):
    nibabel = pytest.importorskip("nibabel")
    maps = vertex_maps(result.vertices, result.faces, result.sphere)
    write_scalars(tmp_path / "a.shape.gii", maps, metadata={"structure": "CortexLeft"})
    image = nibabel.load(tmp_path / "a.shape.gii")
    assert [array.meta["Name"] for array in image.darrays] == list(maps)
    assert image.meta["AnatomicalStructurePrimary"] == "CortexLeft"
    assert np.allclose(image.darrays[1].data, maps["angles"])
    write_scalars(tmp_path / "lh.angles", {"angles": maps["angles"]})
    assert np.allclose(nibabel.freesurfer.read_morph_data(tmp_path / "lh.angles"), maps["angles"])
    write_scalars(tmp_path / "a.npz", maps)
    with np.load(tmp_path / "a.npz") as archive:
        assert np.array_equal(archive["factor"], maps["factor"])
    with pytest.raises(FileError, match="hold one map"):
        write_scalars(tmp_path / "lh.both", maps)
    with pytest.raises(FileError, match="scalar maps are written to"):
        write_scalars(tmp_path / "a.txt", maps)
