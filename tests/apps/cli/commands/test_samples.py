"""`igl-spheremap samples`."""

import json

from igl_spheremap import samples
from igl_spheremap.apps.cli import main


def test_every_sample_is_listed_with_its_parameters(capsys):
    assert main(["samples"]) == 0
    out = capsys.readouterr().out
    assert main(["samples", "--json", "-"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert tuple(figures) == samples.names()
    for name, entry in figures.items():
        assert f"\n{name} " in f"\n{out}"
        first, *_ = entry["parameters"]
        assert first == "n_vertices"
        assert entry["is"]
