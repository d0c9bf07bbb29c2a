"""`igl-spheremap batch`: every file has its line, and what is done is not done again."""

from __future__ import annotations

import csv
import json
import math
import os
import signal
from concurrent.futures import as_completed
from pathlib import Path

import deadly
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


def map_one(method="auto", force=False, balance=0.0):
    return batch.map_one(job(), method, False, False, force, balance)


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
    assert "without the mark" in outcome.message
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
        (["300.ply", "--out", "{folder.nope}/x.ply"], 64),
        (["300.ply", "--out", "{folder:d}.ply"], 64),
        (["300.ply", "--out", "{stem:>9999999999}.ply"], 64),
        (["300.ply", "--out", "{stem!r}.ply"], 64),
        (["300.ply", "--out", "{stem.ply"], 64),
        (["300.ply", "--out", "{stem}" + 300 * "x" + ".ply"], 74),
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


def test_no_cell_of_a_table_is_a_formula_and_any_name_has_a_line(tmp_path):
    names = ["=1+1", "+x", "-x", "@x", "\tx", os.fsdecode(b"bad\xff"), "plain"]
    rows = table([Outcome(f"{name}.ply", "b.ply", status=Exit.NO_MESH, message="=x") for name in names], comma=True)
    (tmp_path / "rows.csv").write_text(rows, encoding="utf-8", errors="backslashreplace")
    with open(tmp_path / "rows.csv", newline="", encoding="utf-8") as file:
        read = list(csv.DictReader(file))
    assert [row["source"] for row in read] == [f"'{name}.ply" for name in names[:5]] + ["bad\\udcff.ply", "plain.ply"]
    assert {row["message"] for row in read} == {"'=x"}
    lines = table([Outcome(f"{name}.ply", "b.ply") for name in names], comma=False).splitlines()
    assert [json.loads(line)["source"] for line in lines] == [f"{name}.ply" for name in names]


def test_a_name_without_an_encoding_spoils_no_summary(desk, capsys):
    try:
        os.rename("300.ply", b"bad\xff.ply")
    except OSError:
        pytest.skip("this file system takes no such names")
    source = os.fsdecode(b"bad\xff.ply")
    assert main(["batch", source, "--out", "{stem}.obj", "--jobs", "1", "--summary", "all.csv"]) == Exit.OK
    assert "1 of 1 files" in capsys.readouterr().out
    assert rows("all.csv")[0]["source"] == "bad\\udcff.ply"


def test_a_process_that_dies_costs_its_mesh_only(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(batch, "map_one", deadly.map_one)
    files = ["1.ply", "deadly.ply", "2.ply", "3.ply"]
    assert main(["batch", *files, "--out", "{stem}.obj", "--jobs", "2", "--summary", "all.jsonl"]) == Exit.FAILED
    statuses = {row["source"]: row["status"] for row in rows("all.jsonl")}
    assert statuses == {name: Exit.FAILED if name == "deadly.ply" else Exit.OK for name in files}
    assert "deadly.ply: the process that mapped it died" in " ".join(capsys.readouterr().out.split())


def test_ctrl_c_finishes_what_was_begun_and_counts_what_is_left(tmp_path, monkeypatch, capsys):
    def pressed(futures):
        yield next(as_completed(futures))
        raise KeyboardInterrupt

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(batch, "map_one", deadly.map_one)
    monkeypatch.setattr(batch, "as_completed", pressed)
    files = [f"{k}.ply" for k in range(400)]
    assert main(["batch", *files, "--out", "{stem}.obj", "--jobs", "1", "--summary", "all.csv"]) == Exit.INTERRUPTED
    out, err = capsys.readouterr()
    done = rows("all.csv")
    assert 0 < len(done) <= len(files)
    assert {row["status"] for row in done} == {"0"}
    assert len(done) == len(files) or f"{len(files) - len(done)} files are left" in out
    assert err == "igl-spheremap: finishing the meshes that were begun; Ctrl-C again ends at once\n"
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
