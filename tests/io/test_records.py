"""Polygons and the triangles they are cut into."""

from __future__ import annotations

import pytest

from igl_spheremap import MeshError
from igl_spheremap.io.files import read_mesh


def test_polygons_are_refused_unless_asked(tmp_path):
    path = tmp_path / "mesh.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 2 3 4\n")
    with pytest.raises(
        MeshError, match=r"faces are not triangles: 1 of 2 .* face 1 with 4; .*triangulate=True"
    ):
        read_mesh(path)
    assert read_mesh(path, triangulate=True).f.tolist() == [[0, 1, 2], [1, 2, 3], [1, 3, 0]]
