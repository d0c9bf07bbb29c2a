"""`igl-spheremap batch`: every file has its line, and what is done is not done again."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.commands import batch
from igl_spheremap.apps.cli.exits import Exit
from igl_spheremap.apps.cli.outcomes import Outcome, summary, table
from igl_spheremap.io import read_mark, read_mesh, write_mesh
from igl_spheremap.sphere.moebius import moebius


@pytest.fixture
def desk(tmp_path, monkeypatch):
    """Two meshes, an open one, and no file where a fourth is named."""
    monkeypatch.chdir(tmp_path)
    for size in (300, 600):
        v, f = ism.samples.make("spheroid", n_vertices=size)
        write_mesh(f"{size}.ply", v, f)
    write_mesh("open.ply", v, f[1:])
    return tmp_path


def rows(path):
    if path.endswith(".csv"):
        with open(path, newline="") as file:
            return list(csv.DictReader(file))
    with open(path) as file:
        return [json.loads(line) for line in file]


def test_a_batch_maps_what_can_be_mapped_and_goes_on(desk, capsys):
    files = ["600.ply", "open.ply", "300.ply", "missing.ply"]
    arguments = ["batch", *files, "--out", "{folder}/{stem}_sphere.obj", "--jobs", "2"]
    assert main([*arguments, "--summary", "first.csv"]) == max(Exit.NO_MESH, Exit.FILE)
    first = rows("first.csv")
    assert [row["source"] for row in first] == files
    assert [int(row["status"]) for row in first] == [Exit.OK, Exit.NO_MESH, Exit.OK, Exit.FILE]
    assert "open surface" in first[1]["message"]
    assert first[1]["energy"] == ""
    for row in (first[0], first[2]):
        v, f = read_mesh(row["source"])
        result = ism.spherical_conformal_map(v, f)
        assert np.array_equal(read_mesh(row["target"]).v, result.sphere)
        assert float(row["energy"]) == pytest.approx(result.energy)
        assert float(row["mean_angle"]) == pytest.approx(np.abs(result.angle_differences()).mean())
    assert "2 of 4 files" in capsys.readouterr().out

    before = (desk / "300_sphere.obj").stat().st_mtime_ns
    write_mesh("open.ply", *ism.samples.sphere(42), force=True)
    assert main([*arguments[:4], *arguments[5:], "--summary", "second.jsonl", "-q"]) == Exit.OK
    second = rows("second.jsonl")
    assert [row["resumed"] for row in second] == [True, False, True]
    assert (desk / "300_sphere.obj").stat().st_mtime_ns == before
    assert capsys.readouterr().out == ""


def job(source="300.ply", target="out.ply"):
    return Outcome(source, target)


def map_one(method="auto", force=False):
    return batch.map_one(job(), method, False, False, force)


def test_what_this_mesh_and_method_made_is_certified_again(desk):
    assert (map_one().status, map_one().resumed) == (Exit.OK, True)
    x, f = read_mesh("out.ply")
    mark = read_mark("out.ply")
    write_mesh("out.ply", -x, f, force=True, metadata={"mark": mark})
    assert map_one().status == Exit.FOLDINGS
    anew = map_one(force=True)
    assert (anew.status, anew.foldings, anew.resumed) == (Exit.OK, 0, False)


def shift(x):
    """A Moebius map: certified, but not what this package makes."""
    return moebius(x, [0.4, 0.1, 0])


def fold(x):
    return x * np.where(np.arange(len(x)) < 5, -1, 1)[:, None]


@pytest.mark.parametrize("change", [shift, fold])
def test_what_others_made_is_neither_taken_for_a_result_nor_lost(change, desk):
    """As FreeSurfer's own lh.sphere at the name that --out gives."""
    v, f = read_mesh("300.ply")
    write_mesh("out.ply", change(ism.spherical_conformal_map(v, f).sphere), f)
    before = Path("out.ply").read_bytes()
    outcome = map_one()
    assert (outcome.status, outcome.resumed) == (Exit.FILE, False)
    assert "its mark does not say" in outcome.message
    assert "--force" in outcome.message
    assert Path("out.ply").read_bytes() == before
    assert map_one(force=True).status == Exit.OK
    assert Path("out.ply").read_bytes() != before


def test_results_of_another_method_mesh_or_version_are_not_there_already(desk, monkeypatch):
    assert map_one().status == Exit.OK
    assert map_one("lai2014").status == Exit.FILE
    v, f = read_mesh("300.ply")
    write_mesh("300.ply", v * 1.5, f, force=True)
    assert map_one().status == Exit.FILE
    write_mesh("300.ply", v, f, force=True)
    assert map_one().resumed
    monkeypatch.setattr("igl_spheremap.io.marks.__version__", "0.0.0")  # nothing else changes a version
    assert map_one().status == Exit.FILE


@pytest.mark.parametrize("content", [b"", b"notes", b"ply\n"])
def test_files_that_hold_no_mesh_are_left_as_they_are(content, desk):
    Path("out.ply").write_bytes(content)
    assert map_one().status == Exit.FILE
    assert Path("out.ply").read_bytes() == content


@pytest.mark.parametrize(
    ("arguments", "status"),
    [
        (["300.ply", "600.ply", "--out", "same.ply"], 64),
        (["300.ply", "--out", "{folder}/{name}"], 64),
        (["300.ply", "600.ply", "--out", "600.ply", "--force"], 64),
        (["300.ply", "--out", "{stem}_sphere.stl"], 64),
        (["scan.csv", "--out", "sphere.ply", "--summary", "scan.csv"], 64),
        (["300.ply", "--out", "{where}.ply"], 64),
        (["300.ply", "--out", "{stem}_sphere.ply", "--jobs", "0"], 64),
        (["300.ply", "--out", "{stem}_sphere.ply", "--summary", "table.txt"], 64),
        (["-", "--out", "sphere.ply"], 64),
        (["300.ply", "--out", "nowhere/{stem}.ply"], 74),
        (["300.ply", "--out", "{stem}.xyz"], 74),
    ],
)
def test_what_makes_no_sense_is_refused_before_the_work(arguments, status, desk, capsys):
    before = sorted(desk.iterdir())
    assert main(["batch", *arguments]) == status
    assert sorted(desk.iterdir()) == before
    assert capsys.readouterr().err.count("\n") == 1


def test_an_interrupted_batch_says_what_is_left():
    done = [Outcome("a.ply", "b.ply"), Outcome("c.ply", "d.ply", status=3, foldings=7)]
    text = summary(done, 5)
    assert "1 of 5 files" in text
    assert "7 foldings remain" in text
    assert "3 files are left" in text


def test_tables_hold_what_is_known():
    (entry,) = [json.loads(line) for line in table([Outcome("a", "b", energy=math.nan)], comma=False).splitlines()]
    assert entry["energy"] is None
    assert len(table([Outcome("a", "b")] * 3, comma=True).splitlines()) == 4
