"""A folder with small meshes."""

import pytest

import igl_spheremap as ism


@pytest.fixture
def desk(tmp_path, monkeypatch):
    """Four meshes and an open one, in the working directory."""
    monkeypatch.chdir(tmp_path)
    for size in (100, 200, 300, 400):
        v, f = ism.samples.make("spheroid", n_vertices=size)
        ism.write_mesh(f"{size}.ply", v, f)
    ism.write_mesh("open.ply", v, f[1:])
    return tmp_path
