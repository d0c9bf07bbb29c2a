"""`igl-spheremap transfer`: what `ism.transfer` gives, in a file."""

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.io.files import write_mesh
from igl_spheremap.io.scalars import read_scalars, write_scalars
from igl_spheremap.shapes.transfer import regular_mesh


@pytest.fixture
def desk(tmp_path, monkeypatch):
    """A surface, its map, and two scalar maps over it."""
    monkeypatch.chdir(tmp_path)
    result = ism.spherical_conformal_map(*ism.samples.make("pear", n_vertices=600))
    write_mesh("pear.ply", result.vertices, result.faces)
    write_mesh("sphere.ply", 3 * result.sphere, result.faces)
    height = result.vertices[:, 2]
    write_scalars("data.npz", {"height": height, "part": (height > 0).astype(float)})
    return result


def test_data_go_to_a_regular_sphere(desk, capsys):
    assert main(["transfer", "pear.ply", "sphere.ply", "out.npz", "--data", "data.npz", "--to", "ico:2"]) == 0
    assert "height, -" in capsys.readouterr().out
    carried = read_scalars("out.npz")
    expected = ism.transfer(desk, desk.vertices[:, 2], regular_mesh("ico:2")[0])
    assert np.allclose(carried["height"], expected, atol=1e-9)


def test_labels_stay_labels_on_another_map(desk):
    other = ism.spherical_conformal_map(*ism.samples.make("pear", n_vertices=400))
    write_mesh("other.ply", other.sphere, other.faces)
    words = ["transfer", "pear.ply", "sphere.ply", "out.npz", "--data", "data.npz:part", "--to", "other.ply"]
    assert main([*words, "--labels", "-q"]) == 0
    (name, carried), = read_scalars("out.npz").items()
    assert name == "part"
    assert len(carried) == len(other.sphere)
    assert set(carried) == {0.0, 1.0}
    assert ((other.vertices[:, 2] > 0) == carried).mean() > 0.97  # the maps share the frame of their gauge


@pytest.mark.parametrize(
    ("words", "status"),
    [
        (["out.txt"], 74),
        (["out.npz", "--to", "ico:99"], 64),
        (["data.npz", "-f"], 64),
        (["sphere.ply", "-f"], 64),
    ],
)
@pytest.mark.parametrize("data", ["data.npz", "data.npz:part"])
def test_failures_are_one_line(desk, words, status, data, capsys):
    assert main(["transfer", "pear.ply", "sphere.ply", *words, "--data", data]) == status
    assert capsys.readouterr().err.count("\n") == 1
