"""`igl-spheremap check`: a certificate for any map, and none for a map of another mesh."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from shell import SAMPLE, one_line

from igl_spheremap.apps.cli import main
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.write_mesh import write_mesh


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
    assert f"no face folds, but: {len(x)} vertices off the unit sphere" in " ".join(
        capsys.readouterr().out.split()
    )
    assert main(["check", SAMPLE, bumpy, "--json", str(tmp_path / "off.json")]) == 3
    out = " ".join(capsys.readouterr().out.split())
    assert f"{len(x)} vertices are off by -0.048 to +0.048 of the radius, most at vertex " in out
    off = json.loads((tmp_path / "off.json").read_text())["off_radius"]
    assert off["farthest"] in (0, len(x) - 1)
    assert abs(off["highest"] - (1.1 / 1.05 - 1)) < 1e-3
    assert main(["check", SAMPLE, bumpy, "--directions", "-q"]) == 0
    assert main(["repair", SAMPLE, bumpy, round_]) == 0
    assert main(["check", SAMPLE, round_]) == 0


@pytest.mark.parametrize(("decimals", "status"), [(1, 3), (3, 0), (4, 0), (9, 0)])
def test_radii_that_vary_by_the_rounding_of_the_file_are_no_fault(
    decimals, status, sphere, tmp_path, capsys
):
    x, f = read_mesh(sphere)
    path = str(tmp_path / "rounded.off")
    write_mesh(path, np.round(15 * x, decimals), f)
    assert main(["check", SAMPLE, path]) == status
    first, *_ = out = capsys.readouterr().out.split("source")
    assert first.startswith("certificate")
    assert ("certified once scaled to the sphere; radii vary by" in " ".join(first.split())) == (
        decimals in (3, 4)
    )
    assert ("off radius" in "".join(out)) == (decimals < 9)
    noise = np.random.default_rng(0).uniform(-3e-6, 3e-6, (len(x), 1))
    write_mesh(path, x * (1 + noise), f, force=True)  # no rounding makes these radii
    assert main(["check", SAMPLE, path, "-q"]) == 3


def test_a_cube_in_whole_numbers_is_no_rounded_sphere(tmp_path):
    corners = np.indices((3, 3, 3)).reshape(3, -1).T - 1.0
    corners = corners[np.abs(corners).max(axis=1) > 0]
    hull = ConvexHull(corners / np.linalg.norm(corners, axis=1)[:, None])
    outward = (
        np.einsum(
            "ij,ij->i",
            np.cross(*np.diff(hull.points[hull.simplices], axis=1).swapaxes(0, 1)),
            hull.points[hull.simplices[:, 0]],
        )
        > 0
    )
    f = np.where(outward[:, None], hull.simplices, hull.simplices[:, ::-1])
    write_mesh(tmp_path / "cube.off", corners, f)
    assert main(["check", str(tmp_path / "cube.off"), str(tmp_path / "cube.off"), "-q"]) == 3
    assert (
        main(
            ["check", str(tmp_path / "cube.off"), str(tmp_path / "cube.off"), "--directions", "-q"]
        )
        == 0
    )


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
