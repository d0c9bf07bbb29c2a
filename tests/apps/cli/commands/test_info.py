"""`igl-spheremap info`."""

from __future__ import annotations

import json

from shell import SAMPLE

from igl_spheremap.apps.cli import main


def test_info_counts(capsys):
    assert main(["info", SAMPLE, "--json", "-"]) == 0
    judged = json.loads(capsys.readouterr().out)
    assert judged["vertices"] - judged["edges"] + judged["faces"] == 2
    assert judged["deep_limbs"] == []
