"""`igl-spheremap batch`: every file has its line, and finished work is not repeated."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import deadly
import pytest
from shell import read_table

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.commands import batch
from igl_spheremap.apps.cli.commands.batch import counts
from igl_spheremap.apps.cli.exits import Exit
from igl_spheremap.apps.cli.inputs import expand
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.write_mesh import write_mesh
from igl_spheremap.populations.table import Row


@pytest.fixture
def desk(tmp_path, monkeypatch):
    """Two meshes, an open one, and a folder of two FreeSurfer subjects of which one lacks a surface."""
    monkeypatch.chdir(tmp_path)
    for size in (300, 600):
        v, f = ism.samples.make("spheroid", n_vertices=size)
        write_mesh(f"{size}.ply", v, f)
    write_mesh("open.ply", v, f[1:])
    return tmp_path


def test_a_batch_maps_what_can_be_mapped_and_goes_on(desk, capsys):
    files = ["600.ply", "open.ply", "300.ply", "missing.ply"]
    arguments = ["batch", *files, "--out", "{folder}/{stem}_sphere.obj", "--jobs", "2"]
    assert main([*arguments, "--summary", "first.csv"]) == max(Exit.NO_MESH, Exit.FILE)
    first = read_table("first.csv")
    assert [row.source for row in first] == files
    assert [row.status for row in first] == ["certified", "no mesh", "certified", "file"]
    assert "open surface" in first[1].notes
    assert "2 of 4 files" in capsys.readouterr().out

    write_mesh("open.ply", *ism.samples.sphere(42), force=True)
    assert main([*arguments[:4], *arguments[5:], "--summary", "second.tsv", "-q"]) == Exit.OK
    assert [row.resumed for row in read_table("second.tsv")] == [True, False, True]
    assert capsys.readouterr().out == ""


def test_a_batch_takes_the_options_of_a_method_as_map_does(desk, capsys):
    options = ["--polish", "angles", "--gauge", "centred"]
    assert main(["batch", "300.ply", "--out", "{stem}_batch.ply", *options, "-q"]) == Exit.OK
    assert main(["map", "300.ply", "300_map.ply", *options, "-q"]) == Exit.OK
    sphere, mesh = read_mesh("300_batch.ply").v, read_mesh("300.ply")
    assert (sphere == read_mesh("300_map.ply").v).all()
    assert abs(sphere - ism.spherical_conformal_map(mesh.v, mesh.f).sphere).max() > 1e-5


@pytest.mark.parametrize(
    ("arguments", "status"),
    [
        (["300.ply", "600.ply", "--out", "same.ply"], 64),
        (["300.ply", "--out", "{stem}.obj", "--edge-weights", "delaunay"], 64),
        (["300.ply", "--out", "{folder}/{name}"], 64),
        (["300.ply", "600.ply", "--out", "600.ply", "--force"], 64),
        (["300.ply", "--out", "{stem}_sphere.stl"], 64),
        (["300.ply"], 64),
        (["--out", "{stem}.obj"], 64),
        (["*.gii", "--out", "{stem}.obj"], 64),
        (["@none.txt", "--out", "{stem}.obj"], 74),
        ([f"@{os.devnull}", "--out", "{stem}.obj"], 64),
        (["scan.csv", "--out", "sphere.ply", "--summary", "scan.csv"], 64),
        (["300.ply", "--out", "{where}.ply"], 64),
        (["300.ply", "--out", "{folder.nope}/x.ply"], 64),
        (["300.ply", "--out", "{stem:>9999999999}.ply"], 64),
        (["300.ply", "--out", "{stem!r}.ply"], 64),
        (["300.ply", "--out", "{stem.ply"], 64),
        (["300.ply", "--out", "{stem}_sphere.ply", "--jobs", "0"], 64),
        (["300.ply", "--out", "{stem}_sphere.ply", "--timeout", "0"], 64),
        (["300.ply", "--out", "{stem}_sphere.ply", "--summary", "table.txt"], 64),
        (["300.ply", "--out", "{stem}_sphere.ply", "--manifest", "600.ply"], 74),
        (["300.ply", "--out", "{stem}.ply", "--manifest", "x.tsv", "--summary", "x.tsv"], 64),
        (["-", "--out", "sphere.ply"], 64),
        (["300.ply", "--out", "{stem}.xyz"], 74),
    ],
)
def test_what_makes_no_sense_is_refused_before_the_work(arguments, status, desk, capsys):
    before = sorted(desk.iterdir())
    assert main(["batch", *arguments]) == status
    assert sorted(desk.iterdir()) == before
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("lists", [["@a.txt"], ["@b.txt", "@a.txt"]])
def test_a_list_that_names_itself_is_refused_in_one_line(lists, desk, capsys):
    for name, line in zip(("a.txt", "b.txt"), lists, strict=False):
        Path(name).write_text(f"{line}\n")
    assert main(["batch", "@a.txt", "--out", "{stem}.obj"]) == Exit.USAGE
    assert capsys.readouterr().err.endswith("@a.txt names itself; give a list of mesh files\n")


def test_a_list_may_be_named_twice(desk):
    """Only within itself it has no end."""
    Path("a.txt").write_text("300.ply\n")
    Path("b.txt").write_text("@a.txt\n@a.txt\n")
    assert expand(["@b.txt", "@a.txt"]) == ["300.ply"] * 3


def test_the_summary_may_lie_beside_the_results(desk):
    words = ["batch", "300.ply", "--out", "o/{stem}.ply", "--summary", "o/all.tsv", "--jobs", "1"]
    assert main([*words, "-q"]) == Exit.OK
    assert len(read_table("o/all.tsv")) == 1


@pytest.fixture
def stand_in(tmp_path, monkeypatch):
    """A folder in which nothing is mapped, but `deadly.run_job` called in its place."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("igl_spheremap.populations.job.run_job", deadly.run_job)


def test_what_ends_a_process_costs_its_mesh_only(stand_in, capsys):
    files = ["1.ply", "deadly.ply", "2.ply", "slow.ply", "3.ply"]
    Path(".part-1-0-slow.obj").touch()  # of another process
    arguments = ["--out", "{stem}.obj", "--jobs", "2", "--timeout", "3", "--summary", "all.tsv"]
    assert main(["batch", *files, *arguments]) == Exit.FAILED
    rows = {row.source: row for row in read_table("all.tsv")}
    assert {name for name, row in rows.items() if row.status == "failed"} == {
        "deadly.ply",
        "slow.ply",
    }
    assert "its worker died 2 times" in rows["deadly.ply"].notes
    assert "more than 3 s" in rows["slow.ply"].notes
    assert "deadly.ply: its worker died" in " ".join(capsys.readouterr().out.split())
    assert Path(".part-1-0-slow.obj").exists()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals_finish_what_was_begun_and_count_what_is_left(
    number, stand_in, monkeypatch, capsys
):
    def signalled(*words):
        def listen(row):
            if row.source == "0.ply":
                signal.raise_signal(number)
            listener(row)

        *others, listener = words
        return original(*others, listen)

    original = batch.run_many
    monkeypatch.setattr(batch, "run_many", signalled)
    handlers = [signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)]
    files = [f"{k}.ply" for k in range(400)]
    assert (
        main(["batch", *files, "--out", "{stem}.obj", "--jobs", "1", "--summary", "all.csv"])
        == 128 + number
    )
    out, err = capsys.readouterr()
    done = read_table("all.csv")
    assert 0 < len(done) <= 3
    assert {row.status for row in done} == {"certified"}
    assert f"left: {len(files) - len(done)} of {len(files)} files" in out
    assert err == "igl-spheremap: finishing the meshes that were begun; Ctrl-C again ends at once\n"
    assert [signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)] == handlers


def test_a_second_run_is_refused_until_the_first_one_ends_however_it_ends(desk, capsys):
    code = "import igl_spheremap as ism; ism.map_many(['300.ply'], '{stem}.obj', listener=lambda row: input())"
    first = subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE)
    manifest = Path("maps.manifest.jsonl")
    # the result is recorded, not only written
    while not (manifest.exists() and '"row"' in manifest.read_text()):
        assert first.poll() is None
        time.sleep(0.02)
    try:
        assert main(["batch", "300.ply", "--out", "{stem}.obj"]) == Exit.FILE
        err = capsys.readouterr().err
        assert err.count("\n") == 1
        assert (
            f":{first.pid}, writes maps.manifest.jsonl; wait until it ends, or give another --manifest"
            in err
        )
    finally:
        first.kill()
        first.communicate()
    assert main(["batch", "300.ply", "--out", "{stem}.obj"]) == Exit.OK
    assert "1 there already" in capsys.readouterr().out


def test_rewriting_the_list_shifts_no_result(desk):
    write_mesh("400.ply", *ism.samples.make("spheroid", n_vertices=400))
    lists = [
        ["300.ply", "600.ply"],
        ["600.ply", "300.ply"],
        ["400.ply", "600.ply", "300.ply"],
        ["600.ply"],
    ]
    for k, names in enumerate(lists):
        Path("list.txt").write_text("\n".join(names))
        words = ["@list.txt", "--out", "{stem}.obj", "--summary", "all.tsv", "-q", "--jobs", "1"]
        assert main(["batch", *words]) == Exit.OK
        rows = read_table("all.tsv")
        assert [(row.source, row.vertices) for row in rows] == [
            (name, len(read_mesh(name).v)) for name in names
        ]
        assert [row.resumed for row in rows] == [k > 0 and name != "400.ply" for name in names]


@pytest.mark.skipif(
    not os.path.isdir("/proc/self"), reason="a folder that takes no file, even of root's"
)
def test_a_folder_that_cannot_be_written_costs_its_rows(desk):
    arguments = [
        "--out",
        "/proc/{stem}.obj",
        "--manifest",
        "all.jsonl",
        "--summary",
        "all.tsv",
        "-q",
        "--jobs",
        "1",
    ]
    assert main(["batch", "300.ply", *arguments]) == Exit.FILE
    (row,) = read_table("all.tsv")
    assert (row.status, row.notes.partition(":")[0]) == ("file", "can't write /proc/300.obj")


def test_inputs_are_files_globs_and_lists(stand_in, capsys):
    for name in ("b1.ply", "b2.ply", "[x].ply"):
        Path(name).touch()
    Path("list.txt").write_text("# a comment\n\nz.ply\nb?.ply\n")
    assert (
        main(
            [
                "batch",
                "@list.txt",
                "[x].ply",
                "a.ply",
                "--out",
                "{stem}.obj",
                "--summary",
                "all.tsv",
                "--jobs",
                "1",
            ]
        )
        == Exit.OK
    )
    assert capsys.readouterr().out.splitlines()[-1].split() == ["summary", "all.tsv"]
    assert [row.source for row in read_table("all.tsv")] == [
        "z.ply",
        "b1.ply",
        "b2.ply",
        "[x].ply",
        "a.ply",
    ]


def test_subjects_of_freesurfer_keep_their_files(desk):
    pytest.importorskip("nibabel")
    for subject in ("s1", "s2"):
        os.makedirs(f"subjects/{subject}/surf")
        write_mesh(f"subjects/{subject}/surf/lh.white", *read_mesh("300.ply"))
    write_mesh("subjects/s2/surf/rh.white", *read_mesh("600.ply"))
    os.mkdir("subjects/logs")
    before = {path: path.read_bytes() for path in Path("subjects").rglob("*.white")}
    words = ["--out", "{folder}/{name}.conformal", "--summary", "all.tsv", "-q", "--jobs", "1"]
    assert main(["batch", "subjects/*/surf/?h.white", *words]) == Exit.OK
    rows = read_table("all.tsv")
    assert [row.source for row in rows] == sorted(map(str, before))
    assert [row.target for row in rows] == [f"{row.source}.conformal" for row in rows]
    assert before == {path: path.read_bytes() for path in Path("subjects").rglob("*.white")}


def test_an_interrupted_batch_reports_what_is_left():
    done = [Row("a.ply", "b.ply"), Row("c.ply", "d.ply", status="folded", foldings=7)]
    text = counts(done, 5)
    assert "1 of 5 files" in text
    assert "7 foldings remain" in text
    assert "left: 3 of 5 files" in text


def test_a_name_without_an_encoding_spoils_no_summary(desk, capsys):
    try:
        os.rename("300.ply", b"bad\xff.ply")
    except OSError:
        pytest.skip("this file system takes no such names")
    source = os.fsdecode(b"bad\xff.ply")
    assert (
        main(["batch", source, "--out", "{stem}.obj", "--jobs", "1", "--summary", "all.csv"])
        == Exit.OK
    )
    assert "1 of 1 files" in capsys.readouterr().out
    assert read_table("all.csv")[0].source == "bad\\udcff.ply"


def test_names_from_files_change_no_line_and_no_terminal(desk, capsys):
    os.rename("open.ply", name := "a\n\x1b[31mb.ply")
    assert (
        main(["batch", name, "--out", "{stem}.obj", "--jobs", "1", "--summary", "all.tsv"])
        == Exit.NO_MESH
    )
    assert main(["info", "none\x1b[31m.ply"]) == Exit.FILE
    out, err = capsys.readouterr()
    assert "\x1b" not in out + err
    assert "b.ply: open surface" in out
    assert "none\\x1b[31m.ply" in err
