"""`igl-spheremap repair`: folded maps become certified ones."""

from __future__ import annotations

import json

import numpy as np
import pytest
from shell import SAMPLE, one_line

from igl_spheremap.apps.cli import main
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.write_mesh import write_mesh


def test_a_folded_map_is_repaired_where_it_folds(sphere, tmp_path, capsys):
    x, f = read_mesh(sphere)
    x[7] = -x[7]
    write_mesh(tmp_path / "folded.ply", 5 * x, f)
    repaired = tmp_path / "repaired.ply"
    assert main(["repair", SAMPLE, str(tmp_path / "folded.ply"), str(repaired), "--json", "-"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["before"]["certificate"]["folding_free"] is False
    assert figures["after"]["certificate"]["folding_free"] is True
    assert 0 < figures["moved"] < len(x) // 4
    assert np.allclose(np.linalg.norm(read_mesh(repaired).v, axis=1), 5)
    assert main(["check", SAMPLE, str(repaired), "-q"]) == 0


def test_a_map_without_directions_cannot_be_repaired(sphere, tmp_path, capsys):
    x, f = read_mesh(sphere)
    x[7] = 0
    write_mesh(tmp_path / "zero.ply", x, f)
    assert main(["repair", SAMPLE, str(tmp_path / "zero.ply"), str(tmp_path / "out.ply")]) == 2
    assert "e.g. 7;" in one_line(capsys)


def test_nothing_moves_where_nothing_folds(sphere, tmp_path, capsys):
    pytest.importorskip("nibabel")
    write_mesh(tmp_path / "lh.sphere", *read_mesh(sphere))  # float32
    out = tmp_path / "repaired.ply"
    assert main(["repair", SAMPLE, str(tmp_path / "lh.sphere"), str(out), "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["moved"] == 0
