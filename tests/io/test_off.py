"""Dialects of OFF, and what is wrong in damaged ones."""

from __future__ import annotations

import pytest

from igl_spheremap import MeshError
from igl_spheremap.io import read_mesh


@pytest.mark.parametrize("head", ["OFF\n3 1 0", "OFF 3 1 0", "# c\nCOFF\n3 1 3", "3 1 0", "OFF\n# c\n\n3 1"])
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
def test_the_fault_is_named(text, words, tmp_path):
    (tmp_path / "mesh.off").write_text(text)
    with pytest.raises(MeshError, match=words):
        read_mesh(tmp_path / "mesh.off")
