"""What tests of the command line share."""

import pytest

from igl_spheremap.apps.cli import main

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
