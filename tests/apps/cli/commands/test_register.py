"""The command register: its files, and its failures."""

import json
import sys

import numpy as np
import pytest
from drawing import needs_drawing, run
from scipy.spatial.transform import Rotation

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.scalars import read_scalars, write_scalars
from igl_spheremap.io.write_mesh import write_mesh

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


def test_a_turned_map_comes_back(folder, monkeypatch, tmp_path, caplog):
    monkeypatch.chdir(folder)
    out, figures = str(tmp_path / "out.obj"), str(tmp_path / "figures.json")
    assert (
        main(words(out, "--feature", "f=features.npz,features.npz", "--json", figures, "-q")) == 0
    )
    fixed = read_mesh("fixed.obj").v
    assert np.abs(read_mesh(out).v - fixed).max() < 0.01
    with open(figures) as file:
        report = json.load(file)
    assert report["certificate"]["folding_free"]
    assert np.allclose(np.array(report["rotation"]) @ R, np.eye(3), atol=0.01)
    assert [stage["name"] for stage in report["stages"]] == ["start", "rotation", "elastic"]
    shares = [
        record.args[1:] for record in caplog.records if record.args and record.args[0] == "steps"
    ]
    assert shares == sorted(shares)  # by which progress shows the time that is left
    assert shares[0][0] == 0
    assert shares[-1][0] == shares[-1][1]
    assert len(set(shares)) > 3


def test_without_features_depths_are_compared_and_named(folder, monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(folder)
    body = "sample:pear:n_vertices=300"
    ism.write_map("pear.obj", ism.spherical_conformal_map(ism.read_mesh(body)), force=True)
    out = str(tmp_path / "out.obj")
    assert main(["register", body, "pear.obj", body, "pear.obj", out, "--stages", "rotation"]) == 0
    assert "of depth (0.7) 1.0000, of depth (0.35) 1.0000" in " ".join(
        capsys.readouterr().out.split()
    )


def test_one_stage_by_one_feature(folder, monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(folder)
    out = str(tmp_path / "out.sphere.reg")
    pytest.importorskip("nibabel")
    assert (
        main(words(out, "--stages", "rotation", "--feature", "a=features.npz:a,features.npz:a"))
        == 0
    )
    assert "folding-free" in capsys.readouterr().out
    written = read_mesh(out).v
    assert np.allclose(np.linalg.norm(written, axis=1), 100, rtol=1e-6)
    assert np.abs(written / 100 - read_mesh("fixed.obj").v).max() < 0.01


@pytest.mark.parametrize(
    ("options", "status", "sentence"),
    [
        (["--feature", "f=features.npz"], 64, "NAME=SOURCE,TARGET"),
        (["--feature", "f=short.npz,features.npz:a"], 2, "9 values but"),
        (
            ["--feature", "f=features.npz,features.npz:a"],
            64,
            "2 maps in features.npz but 1 in features.npz:a",
        ),
        (["--feature", "f=flat.npz,flat.npz"], 2, "features of the source are constant"),
        (
            ["--feature", "f=features.npz:a,features.npz:a", "--json", "features.npz"],
            64,
            "would be lost",
        ),
        (["--stages", "rotation,warp"], 64, "'warp'"),
        (["--stiffness", "-1"], 64, "--stiffness: -1 is out of range"),
    ],
)
def test_failures_are_one_line(folder, monkeypatch, tmp_path, capsys, options, status, sentence):
    monkeypatch.chdir(folder)
    assert main(words(str(tmp_path / "out.obj"), *options)) == status
    err = capsys.readouterr().err
    assert sentence in err
    assert err.count("\n") == 1
    assert not (tmp_path / "out.obj").exists()


def test_a_reflected_sphere_and_one_of_another_mesh_are_refused(
    folder, monkeypatch, tmp_path, capsys
):
    monkeypatch.chdir(folder)
    write_mesh("mirrored.obj", read_mesh("fixed.obj").v * [-1, 1, 1], F, force=True)
    out = str(tmp_path / "out.obj")
    assert main(["register", SOURCE, "mirrored.obj", SOURCE, "fixed.obj", out]) == 2
    assert "mirrored.obj: the sphere is a mirror image" in capsys.readouterr().err
    assert (
        main(["register", SOURCE, "fixed.obj", "sample:pear:n_vertices=500", "fixed.obj", out]) == 2
    )
    assert "give a map of this mesh" in capsys.readouterr().err


def test_a_mirror_image_is_registered_and_its_sphere_fits_the_file(
    folder, monkeypatch, tmp_path, capsys
):
    """OUT is certified for SOURCE as it is, and --reflect takes it into the frame of TARGET."""
    monkeypatch.chdir(tmp_path)
    right, faces = V * [-1, 1, 1], F[:, ::-1]
    x = read_mesh(folder / "fixed.obj").v
    write_mesh("right.obj", right, faces)
    write_mesh("right_sphere.obj", (x * [-1, 1, 1]) @ R.T, faces)
    write_scalars("right.npz", {"a": np.arange(len(x)) % 7.0})
    data = f"f={folder / 'features.npz'},{folder / 'features.npz'}"
    assert (
        main(
            [
                "register",
                "right.obj",
                "right_sphere.obj",
                SOURCE,
                str(folder / "fixed.obj"),
                "on_left.npz",
                "--reflect",
                "--feature",
                data,
            ]
        )
        == 0
    )
    out = capsys.readouterr().out
    assert "start        correlation of f" in out
    assert "the sphere fits SOURCE as it is" in " ".join(out.split())
    written = ism.read_map("on_left.npz")
    assert np.array_equal(written.vertices, right)
    assert written.settings["reflect"]
    assert "--reflect" in written.run.notes[-1]
    assert np.abs(written.sphere * [-1, 1, 1] - x).max() < 0.01
    for words in (["check"], ["check", "--reflect"]):
        assert main([*words, "on_left.npz", "-q"]) == 0
    words = ["right.obj", "on_left.npz", "out.npz", "--reflect", "--to", str(folder / "fixed.obj")]
    assert main(["transfer", *words, "--data", "right.npz", "--labels", "-q"]) == 0
    assert np.mean(read_scalars("out.npz")["a"] == np.arange(len(x)) % 7.0) > 0.99
    words[2] = "left.obj"
    assert main(["resample", *words, "-q"]) == 0
    again, g = read_mesh("left.obj")
    assert np.array_equal(g, F)
    assert np.abs(again - V).max() < 0.02 * np.ptp(V)


def test_a_mirror_image_starts_from_the_sphere_that_was_given(folder, monkeypatch, tmp_path):
    """No map is made anew: mirrored spheres agree before the first stage as well as the ones that they mirror."""
    monkeypatch.chdir(tmp_path)
    x = read_mesh(folder / "fixed.obj").v
    write_mesh("right.obj", V * [-1, 1, 1], F[:, ::-1])
    write_mesh("right_sphere.obj", x * [-1, 1, 1], F[:, ::-1])
    data = f"f={folder / 'features.npz'}:a,{folder / 'features.npz'}:a"
    assert (
        main(
            [
                "register",
                "right.obj",
                "right_sphere.obj",
                SOURCE,
                str(folder / "fixed.obj"),
                "out.obj",
                "--reflect",
                "--feature",
                data,
                "--stages",
                "rotation",
                "--json",
                "out.json",
                "-q",
            ]
        )
        == 0
    )
    with open("out.json") as file:
        assert json.load(file)["stages"][0]["correlation"][0] > 0.999


def test_hemispheres_of_a_brain(monkeypatch, tmp_path):
    """Sulci agree before the first stage, for the given sphere is mirrored; thickness goes to the left side."""
    pytest.importorskip("nibabel")
    fsaverage = pytest.importorskip("nilearn.datasets").fetch_surf_fsaverage("fsaverage5")
    monkeypatch.chdir(tmp_path)
    for side, word in (("lh", "left"), ("rh", "right")):
        v, f = read_mesh(fsaverage[f"white_{word}"])
        write_mesh(f"{side}.white", v, f)
        ism.write_map(f"{side}.white.balanced", ism.balanced_spherical_map(v, f, balance=0.85))
        for name, key in (("sulc", "sulc"), ("thickness", "thick")):
            write_scalars(
                f"{side}.{name}", {name: read_scalars(fsaverage[f"{key}_{word}"]).popitem()[1]}
            )
    options = [
        "--reflect",
        "--feature",
        "sulc=rh.sulc,lh.sulc",
        "--stages",
        "rotation,moebius",
        "--json",
        "out.json",
    ]
    assert (
        main(
            [
                "register",
                "rh.white",
                "rh.white.balanced",
                "lh.white",
                "lh.white.balanced",
                "rh.on_left",
                "-q",
                *options,
            ]
        )
        == 0
    )
    with open("out.json") as file:
        start, *_, last = (stage["correlation"][0] for stage in json.load(file)["stages"])
    assert start > 0.89
    assert last > 0.93
    assert main(["check", "rh.white", "rh.on_left", "-q"]) == 0
    assert (
        main(
            [
                "transfer",
                "rh.white",
                "rh.on_left",
                "lh.of_right",
                "--data",
                "rh.thickness",
                "--reflect",
                "-q",
                "--to",
                "lh.white.balanced",
            ]
        )
        == 0
    )
    left, carried = (
        read_scalars("lh.thickness")["thickness"],
        read_scalars("lh.of_right")["of_right"],
    )
    assert np.corrcoef(left, carried)[0, 1] > 0.9


@needs_drawing
def test_the_picture_shows_the_moving_sphere_before_and_as_the_fixed_one_after(
    folder, monkeypatch, tmp_path
):
    images = pytest.importorskip("PIL.Image")
    monkeypatch.chdir(folder)
    picture = str(tmp_path / "picture.png")
    options = ["--feature", "f=features.npz:a,features.npz:a", "--screenshot", picture, "-q"]
    done = run([sys.executable, "-m", "igl_spheremap", *words(str(tmp_path / "out.obj"), *options)])
    assert done.returncode == 0, done.stderr
    with images.open(picture) as image:
        pixels = np.asarray(image.convert("RGB"), dtype=float)
    lefts = (1280 * k // 3 for k in range(3))
    fixed, before, after = (pixels[60:400, left : left + 426] for left in lefts)
    assert (fixed.min(axis=2) < 250).mean() > 0.4
    assert np.abs(after - fixed).mean() < 0.3 * np.abs(before - fixed).mean()
