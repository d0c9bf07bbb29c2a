"""`igl-spheremap export`."""

from __future__ import annotations

import pytest

from igl_spheremap import samples, spherical_conformal_map
from igl_spheremap.apps.cli import main
from igl_spheremap.io import write_mesh, write_sphere


@pytest.fixture
def files(tmp_path):
    result = spherical_conformal_map(*samples.make("spheroid", n_vertices=600))
    write_mesh(tmp_path / "source.ply", result.vertices, result.faces)
    write_sphere(tmp_path / "sphere.ply", result.sphere, result.faces)
    return [str(tmp_path / "source.ply"), str(tmp_path / "sphere.ply")]


@pytest.mark.parametrize(
    ("name", "show"),
    [("a.glb", "octahedral"), ("a.obj", "equirectangular"), ("a.ply", "angles"), ("a.shape.gii", "factor"),
     ("lh.factor", "factor"), ("a.npz", "angles")],
)  # fmt: skip
def test_export(name, show, files, tmp_path, capsys):
    for module in ("trimesh", "PIL", "nibabel"):
        pytest.importorskip(module)
    target = str(tmp_path / name)
    assert main(["export", *files, target, "--show", show]) == 0
    assert show in capsys.readouterr().out
    assert main(["export", *files, target, "--show", show]) == 74
    assert main(["export", *files, target, "--show", show, "--force", "-q"]) == 0


def test_export_refuses(files, tmp_path, capsys):
    assert main(["export", *files, str(tmp_path / "a.ply"), "--show", "octahedral"]) == 64
    assert main(["export", *files, str(tmp_path / "a.stl"), "--show", "angles"]) == 74
    assert capsys.readouterr().err.count("\n") == 2
