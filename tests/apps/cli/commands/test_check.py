"""`igl-spheremap check`: a certificate for any map, and none for a map of another mesh."""

from __future__ import annotations

import json

import numpy as np
import pytest
from shell import SAMPLE, one_line

from igl_spheremap.apps.cli import main
from igl_spheremap.io.files import read_mesh, write_mesh


def test_check_needs_one_archive_only(tmp_path, capsys):
    assert main(["map", SAMPLE, str(tmp_path / "a.npz"), "-q"]) == 0
    assert main(["check", str(tmp_path / "a.npz")]) == 0


def test_check_takes_samples_on_both_sides(capsys):
    ball = "sample:sphere:n_vertices=162"
    assert main(["check", ball, ball, "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["angle_differences"]["max"] < 1e-9
    assert main(["check", ball, "sample:unicorn"]) == 64
    assert main(["check", ball, "sample:sphere:n_vertices=42"]) == 2


def test_check_distinguishes_foldings_from_other_meshes(sphere, tmp_path, capsys):
    x, f = read_mesh(sphere)
    write_mesh(tmp_path / "mirror.obj", -x, f)
    assert main(["check", SAMPLE, str(tmp_path / "mirror.obj"), "-q"]) == 3
    write_mesh(tmp_path / "huge.obj", x * 1e3, f)
    assert main(["check", SAMPLE, str(tmp_path / "huge.obj"), "-q"]) == 0
    x[3] = np.nan
    write_mesh(tmp_path / "nan.obj", x, f)
    assert main(["check", SAMPLE, str(tmp_path / "nan.obj")]) == 3
    assert "1 vertices not finite" in capsys.readouterr().out


def test_a_map_off_the_sphere_is_not_certified_until_it_is_repaired(sphere, tmp_path, capsys):
    x, f = read_mesh(sphere)
    bumpy, round_ = str(tmp_path / "bumpy.obj"), str(tmp_path / "round.obj")
    write_mesh(bumpy, x * np.linspace(1, 1.1, len(x))[:, None], f)
    assert main(["check", SAMPLE, bumpy]) == 3
    assert f"no face folds, but: {len(x)} vertices off the unit sphere" in " ".join(capsys.readouterr().out.split())
    assert main(["check", SAMPLE, bumpy, "--json", str(tmp_path / "off.json")]) == 3
    out = " ".join(capsys.readouterr().out.split())
    assert f"{len(x)} vertices are off by -0.048 to +0.048 of the radius, most at vertex " in out
    off = json.loads((tmp_path / "off.json").read_text())["off_radius"]
    assert off["farthest"] in (0, len(x) - 1)
    assert abs(off["highest"] - (1.1 / 1.05 - 1)) < 1e-3
    assert main(["check", SAMPLE, bumpy, "--directions", "-q"]) == 0
    assert main(["repair", SAMPLE, bumpy, round_]) == 0
    assert main(["check", SAMPLE, round_]) == 0


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda x, f: (x[:-1], f[(f < len(x) - 1).all(axis=1)]), "vertices but"),
        (lambda x, f: (x, np.roll(np.arange(len(x)), 1)[f]), "not the same vertex order"),
    ],
)
def test_check_refuses_a_map_of_another_mesh(spoil, words, sphere, tmp_path, capsys):
    write_mesh(tmp_path / "other.obj", *spoil(*read_mesh(sphere)))
    assert main(["check", SAMPLE, str(tmp_path / "other.obj")]) == 2
    assert words in one_line(capsys)
