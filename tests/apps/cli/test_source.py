"""IN: what is refused, in one line, and what `--repair` does."""

from __future__ import annotations

import os

import numpy as np
import pytest
from corpus import CORPUS
from shell import one_line

from igl_spheremap import samples
from igl_spheremap.apps.cli import main
from igl_spheremap.io import write_mesh


@pytest.mark.corpus
@pytest.mark.parametrize("path", sorted((CORPUS / "invalid").glob("*")) or [None], ids=lambda p: p and p.stem)
def test_every_invalid_mesh_is_status_2_and_one_line(path, tmp_path, capfd):
    if path is None:
        pytest.skip("no meshes")
    assert main(["map", str(path), str(tmp_path / "out.obj")]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert str(path) in err
    assert os.listdir(tmp_path) == []


def test_a_soup_is_refused_unless_it_is_repaired(tmp_path, capsys):
    v, f = samples.sphere(42)
    write_mesh(tmp_path / "soup.obj", v[f].reshape(-1, 3), np.arange(3 * len(f)).reshape(-1, 3))
    assert main(["info", str(tmp_path / "soup.obj")]) == 2
    one_line(capsys)
    assert main(["info", str(tmp_path / "soup.obj"), "--repair"]) == 0
    out, err = capsys.readouterr()
    assert "120 edges" in out
    assert "welded 198 coincident vertices" in err
