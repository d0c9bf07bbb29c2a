"""Common code of tests of the command line."""

from pathlib import Path

import pytest

from igl_spheremap.apps.cli import main
from igl_spheremap.io.tables import read_cells
from igl_spheremap.populations.table import from_plain

SAMPLE = "sample:spheroid:n_vertices=500"


@pytest.fixture
def sphere(tmp_path):
    """A map of the sample, written by the command itself."""
    path = tmp_path / "sphere.obj"
    assert main(["map", SAMPLE, str(path), "-q"]) == 0
    return path


def one_line(capsys):
    """The single line of a failure, which is all that was printed."""
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("igl-spheremap: ")
    return err


def read_table(path):
    """The rows of a table that `--summary` wrote."""
    header, *rows = read_cells(Path(path))
    entries = [dict(zip(header, row, strict=True)) for row in rows]
    texts = {"worker", "notes"}
    return [
        from_plain(
            {
                name: cell
                if name in texts
                else cell == "True"
                if name == "resumed"
                else cell or None
                for name, cell in entry.items()
            }
        )
        for entry in entries
    ]
