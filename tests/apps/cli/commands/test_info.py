"""`igl-spheremap info`."""

from __future__ import annotations

import json
import re

import numpy as np
from shell import SAMPLE

import igl_spheremap as ism
from igl_spheremap.apps.cli import main


def test_info_counts(capsys):
    assert main(["info", SAMPLE, "--json", "-"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["vertices"] - figures["edges"] + figures["faces"] == 2
    assert (figures["weights"], figures["error"], figures["repair"]) == ("cotangent", None, None)


def test_what_cannot_be_mapped_is_measured_too(tmp_path, capsys):
    v, f = ism.samples.sphere(162)
    path = str(tmp_path / "open.obj")
    ism.write_mesh(path, v, f[1:])
    assert main(["info", path, "--json", str(tmp_path / "a.json")]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "--repair --fill-holes would do this:" in out
    assert "repair_mesh" not in out
    assert main(["info", path, "--json", "-", "--repair", "--fill-holes"]) == 0
    repaired = json.loads(capsys.readouterr().out)
    assert repaired["maps_to"] == "sphere"
    figures = json.loads((tmp_path / "a.json").read_text())
    assert tuple(repaired["repairs"]) == tuple(figures["actions"]) == ism.info(v, f[1:]).actions
    assert figures["components"][0]["boundary_loops"]


def test_polygons_are_triangulated(tmp_path, capsys):
    (tmp_path / "quads.off").write_text("OFF 4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n")
    assert main(["info", str(tmp_path / "quads.off")]) == 0
    out, err = capsys.readouterr()
    assert "triangulated 1 polygon" in err
    assert "a disk" in out


def test_a_mesh_without_faces_is_refused(tmp_path, capsys):
    (tmp_path / "points.off").write_text("OFF 4 0 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n")
    assert main(["info", str(tmp_path / "points.off")]) == 2
    assert "no faces" in capsys.readouterr().err


def test_a_repaired_surface_is_written_with_what_was_done(tmp_path, capsys):
    """A ring has a handle: cut, it is a sphere, whose report says where."""
    turn = 2 * np.pi * np.arange(24) / 24
    u, t = (each.ravel() for each in np.meshgrid(turn, turn, indexing="ij"))
    v = np.column_stack(((3 + np.cos(t)) * np.cos(u), (3 + np.cos(t)) * np.sin(u), np.sin(t)))
    i = np.arange(576).reshape(24, 24)
    a, b, c, d = (
        each.ravel() for each in (i, np.roll(i, -1, 0), np.roll(i, -1, (0, 1)), np.roll(i, -1, 1))
    )
    ring, ball = str(tmp_path / "ring.off"), str(tmp_path / "ball.off")
    ism.write_mesh(ring, v, np.vstack((np.column_stack((a, b, c)), np.column_stack((a, c, d)))))
    assert main(["info", ring, "--repair", "--cut-handles", "--write", ball, "--json", "-"]) == 0
    (text,) = json.loads(capsys.readouterr().out)["repairs"]
    assert re.search(r"cut 1 handle, a \w+ loop of 24 edges and length [\d.]+ near \(", text)
    ism.check_mesh(*ism.read_mesh(ball))
    assert main(["info", ring, "--write", ball]) != 0
    assert "exists" in capsys.readouterr().err
