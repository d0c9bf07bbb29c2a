"""`igl-spheremap summarise`: quantiles and outliers of a table, or of a manifest."""

from pathlib import Path

import pytest

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.exits import Exit
from igl_spheremap.populations.table import TABLES, Row, write_table

ROWS = [*(Row(f"{k}.ply", f"{k}.obj", mean_angle=k / 100, seconds=k) for k in range(101)),
        Row("far.ply", "far.obj", mean_angle=50.0),
        Row("open.ply", "open.obj", status="no mesh", seconds=1e6, notes="open surface")]


@pytest.mark.parametrize("suffix", TABLES)
def test_quantiles_and_outliers_are_those_of_the_table(suffix, tmp_path, capsys):
    write_table(tmp_path / f"all{suffix}", ROWS)
    assert main(["summarise", str(tmp_path / f"all{suffix}")]) == Exit.OK
    lines = {line.split()[0]: line.split() for line in capsys.readouterr().out.splitlines() if line.strip()}
    assert lines["certified"][1:4] == ["102", "of", "103"]
    assert lines["mean"][2:] == ["0", "0.2525", "0.505", "0.7575", "0.9999", "50"]
    assert lines["seconds"][-1] == "100"  # what failed is not among the maps
    assert lines["outliers"][1:4] == ["1", "of", "103"]
    assert lines["far.ply:"][1:] == ["mean", "angle", "50"]


def test_what_is_rated_fail_is_named_and_left_out(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_table("all.tsv", ROWS)
    Path("ratings.tsv").write_text("source\trating\tcomment\nfar.ply\tfail\ta hole\n0.ply\tpass\t\n1.ply\t\t\n")
    assert main(["summarise", "all.tsv", "--ratings", "ratings.tsv"]) == Exit.OK
    out = capsys.readouterr().out
    assert "1 pass, 1 fail" in out
    assert "far.ply: a hole" in out
    assert "outliers     0 of 102" in out
    Path("ratings.tsv").write_text("source\trating\n0.ply\tgood\n")
    assert main(["summarise", "all.tsv", "--ratings", "ratings.tsv"]) == Exit.NO_MESH
    assert "is rated 'good'" in capsys.readouterr().err


def test_a_manifest_is_summarised_as_the_table_of_its_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for size in (200, 300):
        ism.write_mesh(f"{size}.ply", *ism.samples.make("spheroid", n_vertices=size))
    write_table("all.tsv", ism.map_many(["200.ply", "300.ply"], "{stem}.obj", engine=ism.Engine(processes=1)))
    texts = []
    for name in ("all.tsv", "stem.obj.manifest.jsonl"):
        assert main(["summarise", name]) == Exit.OK
        texts.append(capsys.readouterr().out)
    assert texts[0] == texts[1]
    assert "2 of 2 files" in texts[0]
