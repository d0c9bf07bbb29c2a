"""The command register: what it writes, and how it fails."""

import json
import sys

import numpy as np
import pytest
from drawing import needs_drawing, run
from scipy.spatial.transform import Rotation

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.io.files import read_mesh, write_mesh
from igl_spheremap.io.scalars import write_scalars

SOURCE = "sample:pear:n_vertices=800"
V, F = ism.samples.make("pear", n_vertices=800)
R = Rotation.from_euler("ZYZ", [1.0, 0.7, -2.0]).as_matrix()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A map, the map turned, and features that decide the turn."""
    path = tmp_path_factory.mktemp("maps")
    x = ism.spherical_conformal_map(V, F).sphere
    write_mesh(path / "fixed.obj", x, F)
    write_mesh(path / "moving.obj", x @ R.T, F)
    write_scalars(path / "features.npz", {"a": x[:, 0] + x[:, 2] ** 2, "b": x[:, 1] * x[:, 0]})
    write_scalars(path / "short.npz", {"a": x[:9, 0]})
    write_scalars(path / "flat.npz", {"a": np.ones(len(x))})
    return path


def words(*options):
    return ["register", SOURCE, "moving.obj", SOURCE, "fixed.obj", *options]


def test_a_turned_map_comes_back(folder, monkeypatch, tmp_path):
    monkeypatch.chdir(folder)
    out, figures = str(tmp_path / "out.obj"), str(tmp_path / "figures.json")
    assert main(words(out, "--feature", "f=features.npz,features.npz", "--json", figures, "-q")) == 0
    fixed = read_mesh("fixed.obj").v
    assert np.abs(read_mesh(out).v - fixed).max() < 0.01
    with open(figures) as file:
        report = json.load(file)
    assert report["certificate"]["folding_free"]
    assert np.allclose(np.array(report["rotation"]) @ R, np.eye(3), atol=0.01)
    assert [stage["name"] for stage in report["stages"]] == ["start", "rotation", "moebius", "elastic"]


def test_one_stage_by_one_feature(folder, monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(folder)
    out = str(tmp_path / "out.sphere.reg")
    pytest.importorskip("nibabel")
    assert main(words(out, "--stages", "rotation", "--feature", "a=features.npz:a,features.npz:a")) == 0
    assert "folding-free" in capsys.readouterr().out
    written = read_mesh(out).v
    assert np.allclose(np.linalg.norm(written, axis=1), 100, rtol=1e-6)
    assert np.abs(written / 100 - read_mesh("fixed.obj").v).max() < 0.01


@pytest.mark.parametrize(("options", "status", "sentence"), [
    (["--feature", "f=features.npz"], 64, "NAME=MOVING,FIXED"),
    (["--feature", "f=short.npz,features.npz:a"], 2, "9 values but"),
    (["--feature", "f=flat.npz,flat.npz"], 2, "features of the moving surface are constant"),
    (["--feature", "f=features.npz:a,features.npz:a", "--json", "features.npz"], 64, "would be lost"),
    (["--stages", "rotation,warp"], 64, "'warp'"),
    (["--stiffness", "-1"], 64, "--stiffness: -1 is out of range"),
])
def test_failures_are_one_line(folder, monkeypatch, tmp_path, capsys, options, status, sentence):
    monkeypatch.chdir(folder)
    assert main(words(str(tmp_path / "out.obj"), *options)) == status
    err = capsys.readouterr().err
    assert sentence in err
    assert err.count("\n") == 1
    assert not (tmp_path / "out.obj").exists()


def test_a_reflected_sphere_and_one_of_another_mesh_are_refused(folder, monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(folder)
    write_mesh("mirrored.obj", read_mesh("fixed.obj").v * [-1, 1, 1], F, force=True)
    out = str(tmp_path / "out.obj")
    assert main(["register", SOURCE, "mirrored.obj", SOURCE, "fixed.obj", out]) == 2
    assert "mirrored.obj: the sphere is a reflection" in capsys.readouterr().err
    assert main(["register", SOURCE, "fixed.obj", "sample:pear:n_vertices=500", "fixed.obj", out]) == 2
    assert "give a map of this mesh" in capsys.readouterr().err


@needs_drawing
def test_the_picture_shows_the_moving_sphere_before_and_as_the_fixed_one_after(folder, monkeypatch, tmp_path):
    images = pytest.importorskip("PIL.Image")
    monkeypatch.chdir(folder)
    picture = str(tmp_path / "picture.png")
    options = ["--feature", "f=features.npz:a,features.npz:a", "--screenshot", picture, "-q"]
    done = run([sys.executable, "-m", "igl_spheremap", *words(str(tmp_path / "out.obj"), *options)])
    assert done.returncode == 0, done.stderr
    with images.open(picture) as image:
        pixels = np.asarray(image.convert("RGB"), dtype=float)
    fixed, before, after = (pixels[60:380, 400 * k : 400 * k + 400] for k in range(3))
    assert (fixed.min(axis=2) < 250).mean() > 0.4
    assert np.abs(after - fixed).mean() < 0.3 * np.abs(before - fixed).mean()
