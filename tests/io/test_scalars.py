"""Scalar maps over the vertices: what is written reads back, what is none is named."""

from __future__ import annotations

import numpy as np
import pytest

from igl_spheremap import FileError, MeshError
from igl_spheremap.io import read_scalars, write_mesh, write_scalars
from igl_spheremap.samples import sphere

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
