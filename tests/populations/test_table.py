"""Tables hold the facts of every input, whatever its name."""

import csv
import math
import os

import pytest
from shell import read_table

from igl_spheremap.populations.table import TABLES, Row, fences, outlying, plain, write_table

NAMES = ["=1+1", "+x", "-x", "@x", "\tx", "'quoted", "'=x", "a,b", "two\nlines", "plain"]
ROWS = [
    Row(f"{name}.ply", f"{name}.obj", vertices=k, energy=0.1 + k, notes="=x")
    for k, name in enumerate(NAMES)
]


@pytest.mark.parametrize("suffix", TABLES)
def test_tables_are_read_back_as_they_were_written(suffix, tmp_path):
    rows = [*ROWS, Row("none.ply", "none.obj", status="no mesh", resumed=True)]
    write_table(tmp_path / f"all{suffix}", rows)
    assert [plain(row) for row in read_table(tmp_path / f"all{suffix}")] == [
        plain(row) for row in rows
    ]


def test_no_cell_of_a_table_is_a_formula(tmp_path):
    write_table(tmp_path / "rows.csv", ROWS)
    with open(tmp_path / "rows.csv", newline="", encoding="utf-8") as file:
        read = list(csv.DictReader(file))
    assert [row["source"] for row in read[:5]] == [f"'{name}.ply" for name in NAMES[:5]]
    assert {row["notes"] for row in read} == {"'=x"}


def test_what_is_not_finite_is_null_or_empty(tmp_path):
    assert plain(Row("a", "b", energy=math.nan))["energy"] is None
    write_table(tmp_path / "row.tsv", [Row("a", "b", energy=math.inf)])
    head, cells = (line.split("\t") for line in (tmp_path / "row.tsv").read_text().splitlines())
    assert cells[head.index("energy")] == ""


def test_no_figure_is_an_outlier_by_rounding():
    """The quartiles of 0, 0, 0, 1 are 0 and 1/4, and 1 lies at the fence."""
    rows = [Row("a", "b", mean_angle=0.3 + 0.7 * angle) for angle in (0, 0, 0, 1)]
    assert [outlying(row, fences(rows)) for row in rows] == 4 * [[]]
    assert outlying(Row("a", "b", mean_angle=1.01), fences(rows)) == ["mean_angle"]


def test_a_name_without_an_encoding_spoils_no_table(tmp_path):
    name = os.fsdecode(b"bad\xff.ply")
    for suffix in TABLES:
        write_table(tmp_path / f"all{suffix}", [Row(name, "b")])
        assert "udcff.ply" in (tmp_path / f"all{suffix}").read_text("utf-8")
