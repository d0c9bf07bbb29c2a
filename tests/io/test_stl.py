"""STL: triangles that are welded."""

from __future__ import annotations

import numpy as np
import pytest

from igl_spheremap import MeshError
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.write_mesh import write_mesh


@pytest.mark.parametrize("kind", ["binary", "text", "capitals"])
def test_stl_is_welded_in_order_of_appearance(kind, ball, tmp_path):
    v, f = ball
    path = tmp_path / "ball.stl"
    if kind == "binary":
        write_mesh(path, v, f)
    else:
        corners = "\n".join(
            "outer loop\n"
            + "\n".join("vertex {!r} {!r} {!r}".format(*v[i].tolist()) for i in face)
            + "\nendloop"
            for face in f
        )
        text = f"solid ball\n{corners}\nendsolid ball\n"
        path.write_text(text.upper() if kind == "capitals" else text)
    mesh = read_mesh(path)
    assert mesh.v.shape == v.shape
    assert np.allclose(mesh.v[mesh.f], v[f], atol=1e-7)
    assert mesh.f[0].tolist() == [0, 1, 2]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("solid a\nvertex 0 0 0\nvertex 1 0 0\n", "cut off"),
        ("no triangles here", "neither text STL nor binary"),
    ],
)
def test_the_fault_is_named(text, words, tmp_path):
    (tmp_path / "mesh.stl").write_text(text)
    with pytest.raises(MeshError, match=words):
        read_mesh(tmp_path / "mesh.stl")
