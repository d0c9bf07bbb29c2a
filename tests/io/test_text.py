"""Dialects of OBJ and OFF, and the faults of damaged files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from igl_spheremap import MeshError
from igl_spheremap.io.files import read_mesh


def obj(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "mesh.obj"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    "faces",
    [
        "f 1 2 3",
        "f 1/1 2/2 3/3",
        "f 1//1 2//2 3//3",
        "f -3 -2 -1",
        "f 1/1/1 \\\n 2/2/2 3/3/3",
        "  f 1 2 3 # done",
        "vt 0 0\nvn 0 0 1\ng part\nusemtl red\nf 1 2 3\nl 1 2",
    ],
)
def test_obj_dialects(faces, tmp_path):
    mesh = read_mesh(obj(tmp_path, f"# head\nv 0 0 0 1\r\nv 1 0 0 1 0 0\nv\t0 1e0 0\n{faces}\n"))
    assert mesh.v.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert mesh.f.tolist() == [[0, 1, 2]]


def test_negative_obj_indices_count_from_where_they_stand(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 1\nf -4 -1 -2\n"
    assert read_mesh(obj(tmp_path, text)).f.tolist() == [[0, 1, 2], [0, 3, 2]]


def test_not_finite_coordinates_reach_the_gate(tmp_path):
    mesh = read_mesh(obj(tmp_path, "v 0 nan 0\nv inf 0 0\nv 0 -INF 0\nf 1 2 3\n"))
    assert np.isnan(mesh.v[0, 1])
    assert np.isinf(mesh.v[[1, 2], [0, 1]]).all()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("v 0 0\nf 1 2 3\n", "vertex 0 reads '0 0'"),
        ("v 0 0 0\nv 1 x 0\n", "vertex 1 reads '1 x 0'"),
        ("v 0 0 0\nv 1 1_0 0\n", "vertex 1 reads '1 1_0 0'"),
        ("v 0 0 0\nf 1 2 c\n", "face 0 reads '1 2 c'"),
        ("v 0 0 0\nf 1 2 1_0\n", "face 0 reads '1 2 1_0'"),
        ("v 0 0 0\nf 1 2 99999999999999999999\n", "face 0 reads"),
        ("v 0 0 0\nf 1 2\n", "not triangles"),
    ],
)
def test_the_fault_is_named(text, words, tmp_path):
    (tmp_path / "mesh.obj").write_text(text)
    with pytest.raises(MeshError, match=words):
        read_mesh(tmp_path / "mesh.obj")


@pytest.mark.parametrize(
    "head", ["OFF\n3 1 0", "OFF 3 1 0", "# c\nCOFF\n3 1 3", "3 1 0", "OFF\n# c\n\n3 1"]
)
def test_off_dialects(head, tmp_path):
    (tmp_path / "mesh.off").write_text(
        f"{head}\n0 0 0 255 0 0\n1 0 0 255 0 0\n\n0 1 0 255 0 0\n3 0 1 2 9 9 9\n"
    )
    mesh = read_mesh(tmp_path / "mesh.off")
    assert mesh.v.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert mesh.f.tolist() == [[0, 1, 2]]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("OFF\n8 6 0\n0 0 0\n", "1 lines follow"),
        ("OFF BINARY\n", "no OFF header"),
        ("OFF\n1 1 0\n0 0 0\n3 0 0\n", "as many whole numbers"),
        ("OFF\n999999999999 6 0\n0 0 0\n", "1 lines follow"),
    ],
)
def test_off_the_fault_is_named(text, words, tmp_path):
    (tmp_path / "mesh.off").write_text(text)
    with pytest.raises(MeshError, match=words):
        read_mesh(tmp_path / "mesh.off")
