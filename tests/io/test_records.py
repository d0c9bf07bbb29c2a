"""Polygons and the triangles they are cut into."""

from __future__ import annotations

import numpy as np
import pytest

from igl_spheremap import MeshError
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.records import Polygons


def test_polygons_are_refused_unless_asked(tmp_path):
    path = tmp_path / "mesh.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 2 3 4\n")
    with pytest.raises(
        MeshError, match=r"faces are not triangles: 1 of 2 .* face 1 with 4; .*triangulate=True"
    ):
        read_mesh(path)
    assert read_mesh(path, triangulate=True).f.tolist() == [[0, 1, 2], [0, 1, 2], [0, 2, 3]]


def test_fans_of_any_size():
    sizes = np.array([3, 5, 4, 3])
    f = Polygons(np.arange(15), sizes).triangles(triangulate=True)
    slow = [
        [start, start + k, start + k + 1]
        for start, size in zip(np.cumsum(sizes) - sizes, sizes, strict=True)
        for k in range(1, size - 1)
    ]
    assert f.tolist() == slow
