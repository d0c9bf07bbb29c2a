"""`igl-spheremap info`."""

from __future__ import annotations

import json

from shell import SAMPLE

from igl_spheremap.apps.cli import main


def test_info_counts(capsys):
    assert main(["info", SAMPLE, "--json", "-"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["vertices"] - told["edges"] + told["faces"] == 2
    assert told["deep_limbs"] == []
