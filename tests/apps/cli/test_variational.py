"""The commands for p-harmonic maps and landmarks: what they write, and how they fail."""

import json
import os

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.commands.landmarks import read_points
from igl_spheremap.io import read_mesh

SOURCE = "sample:spheroid:n_vertices=300"
V, F = ism.samples.make("spheroid", n_vertices=300)


def test_p_harmonic_writes_the_map_of_the_api(tmp_path):
    out = tmp_path / "out.obj"
    assert main(["p-harmonic", SOURCE, str(out), "-p", "3", "--quiet"]) == 0
    assert np.allclose(read_mesh(out).v, ism.p_harmonic_map(V, F, 3).sphere, atol=1e-12)


def test_p_at_most_one_is_a_usage_error(tmp_path, capsys):
    assert main(["p-harmonic", SOURCE, str(tmp_path / "out.obj"), "-p", "1"]) == 64
    assert "above 1" in capsys.readouterr().err


def test_landmarks_come_from_a_file_and_their_misses_are_reported(tmp_path, capsys):
    points, out = tmp_path / "points.txt", tmp_path / "out.obj"
    targets = V[[5, 100, 200]] @ [[0, 1, 0], [-1, 0, 0], [0, 0, 1]] + [0.1, 0, 0.1]
    lines = [f"{vertex} {x} {y} {z}" for vertex, (x, y, z) in zip((5, 100, 200), targets, strict=True)]
    points.write_text("# vertex x y z weight\n" + lines[0] + " 7\n\n" + lines[1].replace(" ", ", ") + "\n" + lines[2])
    vertices, read, weights = read_points(str(points), 50.0)
    assert vertices.tolist() == [5, 100, 200]
    assert np.array_equal(read, targets)
    assert weights.tolist() == [7, 50, 50]
    figures = tmp_path / "figures.json"
    words = ["landmarks", SOURCE, str(out), "--points", str(points), "--weight", "50", "--json", str(figures)]
    assert main(words) == 0
    expected = ism.landmark_map(V, F, vertices, targets, weights).sphere
    assert np.allclose(read_mesh(out).v, expected, atol=1e-12)
    unit = targets / np.linalg.norm(targets, axis=1)[:, None]
    misses = np.degrees(np.arccos((expected[vertices] * unit).sum(axis=1)))
    found = json.loads(figures.read_text())["landmarks"]
    assert [one["vertex"] for one in found] == [5, 100, 200]
    assert [one["miss"] for one in found] == pytest.approx(misses, rel=1e-6)
    shown = capsys.readouterr().out
    assert all(f"misses its target by {miss:.3g} degrees" in shown for miss in misses)
    assert f"{misses.mean():.3g} degrees on average" in shown


@pytest.mark.parametrize(
    ("text", "status", "words"),
    [
        ("1 0 0\n", 74, "line 1"),
        ("", 74, "no landmarks"),
        ("0 0 0 1\nx 0 0 1\n", 74, "line 2"),
        ("9999 0 0 1\n", 2, "vertex 9999"),
        ("0.5 0 0 1\n", 74, "line 1"),
        ("0 0 0 0\n", 2, "target of landmark 0"),
    ],
)
def test_bad_landmark_files_are_one_line(tmp_path, capsys, text, status, words):
    points = tmp_path / "points.txt"
    points.write_text(text)
    assert main(["landmarks", SOURCE, str(tmp_path / "out.obj"), "--points", str(points)]) == status
    err = capsys.readouterr().err
    assert words in err
    assert err.count("\n") == 1


@pytest.mark.posix
def test_landmarks_from_a_device_or_a_pipe_are_refused_without_reading(tmp_path, capsys):
    os.mkfifo(tmp_path / "pipe")
    for points in ("/dev/zero", str(tmp_path / "pipe")):
        assert main(["landmarks", SOURCE, str(tmp_path / "o.obj"), "--points", points]) == 74
        assert capsys.readouterr().err.endswith("it is a device or a pipe; write its content to a file first\n")


def test_a_missing_landmark_file_is_reported(tmp_path, capsys):
    assert main(["landmarks", SOURCE, str(tmp_path / "o.obj"), "--points", str(tmp_path / "none")]) == 74
    assert "can't read" in capsys.readouterr().err
