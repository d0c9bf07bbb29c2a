"""The command from a surface to registered spheres: progress, resuming, and one line for each fault."""

import json
from pathlib import Path

import numpy as np
import pytest
from cortices import body, turned, write_template
from shell import read_table

from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.exits import Exit
from igl_spheremap.io.files import read_sphere
from igl_spheremap.io.write_mesh import write_mesh

pytest.importorskip("nibabel")


@pytest.fixture
def desk(tmp_path, monkeypatch):
    """Two subjects of a FreeSurfer folder, one of which lacks a side, and a template."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "template").mkdir()
    y, f = turned(300)
    for subject, sides in (("ann", "lr"), ("bob", "l")):
        (tmp_path / "subjects" / subject / "surf").mkdir(parents=True)
        for side in sides:
            mirror, faces = (1, f) if side == "l" else (np.array([-1, 1, 1]), f[:, ::-1])
            write_mesh(f"subjects/{subject}/surf/{side}h.white", body(y) * mirror, faces)
    write_template(tmp_path / "template", hemi="rh")
    return write_template(tmp_path / "template")


def test_subjects_are_registered(desk, capsys):
    words = ["sphere-reg", "subjects/*/surf/?h.white", "--to", desk.replace("{hemi}", "{side}")]
    assert main([*words, "--out", "out"]) == Exit.FILE  # no file L.pial
    words = [
        "sphere-reg",
        "subjects/*/surf/?h.white",
        "subjects/bob/surf/rh.white",
        "--to",
        desk,
        "--names",
        "freesurfer",
        "--jobs",
        "1",
        "--out",
        "out/{subject}",
        "--summary",
        "all.tsv",
        "--report",
        "page.html",
    ]
    assert main(words) == Exit.FILE
    rows = read_table("all.tsv")
    assert [row.status for row in rows] == ["certified", "certified", "certified", "file"]
    assert "3 of 4 files" in capsys.readouterr().out
    assert read_sphere("out/ann/rh.mine.sphere.reg").v.shape == (252, 3)
    assert main([*words, "-q"]) == Exit.FILE
    assert [row.resumed for row in read_table("all.tsv")] == [True, True, True, False]


@pytest.mark.parametrize(
    ("words", "status", "said"),
    [
        (["lh.none"], Exit.USAGE, "--out"),
        (["--out", "x"], Exit.USAGE, "give mesh files"),
        (["lh.a", "--out", "{x}"], Exit.USAGE, "--out {x}: only {folder} and {subject}"),
        (["lh.a", "--out", "x", "--to", "me"], Exit.USAGE, "--to me: give NAME=SURFACE,SPHERE"),
        (["a.ply", "--out", "x", "--to", "fsLR"], Exit.FILE, "or give --hemi L or R"),
        (["lh.a", "--out", "x", "--to", "fsLR"], Exit.FILE, "templateflow"),
        (["lh.a", "--out", "x", "--names", "spm"], Exit.USAGE, "spm"),
        (["lh.a", "--out", "x", "--repair"], Exit.USAGE, "takes no --repair"),
    ],
)
def test_what_is_wrong_takes_a_line(words, status, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name in ("HOME", "USERPROFILE", "NEUROMAPS_DATA", "TEMPLATEFLOW_HOME", "HCPPIPEDIR"):
        monkeypatch.setenv(name, str(tmp_path))
    monkeypatch.setattr("igl_spheremap.io.templates.find_spec", lambda name: None)
    assert main(["sphere-reg", *words]) == status
    err = capsys.readouterr().err
    assert said in err
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_labels_of_another_size_are_refused(desk, capsys):
    np.savez("lh.atlas.npz", atlas=np.zeros(7))
    words = [
        "sphere-reg",
        "subjects/ann/surf/lh.white",
        "--to",
        desk,
        "--out",
        "out",
        "--labels",
        "lh.atlas.npz",
    ]
    assert main(words) == Exit.NO_MESH
    assert "has 7 labels, but mine has 642 vertices" in capsys.readouterr().err


def test_what_was_made_is_recorded_with_its_inputs(desk):
    words = [
        "sphere-reg",
        "subjects/ann/surf/lh.white",
        "--to",
        desk,
        "--out",
        "out",
        "--jobs",
        "1",
        "-q",
    ]
    assert main(words) == Exit.OK
    last = json.loads(Path("out/sphere-reg.manifest.jsonl").read_text().splitlines()[-1])
    assert len(last["read"]) == 3  # the surface, and the template's sphere and surface
    assert len(last["written"]) == 7
