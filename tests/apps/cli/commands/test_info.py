"""`igl-spheremap info`."""

from __future__ import annotations

import json

from shell import SAMPLE

from igl_spheremap.apps.cli import main


def test_info_counts(capsys):
    assert main(["info", SAMPLE, "--json", "-"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["vertices"] - figures["edges"] + figures["faces"] == 2
    assert figures["weights"] == "cotangent"
