"""`igl-spheremap completion`."""

from __future__ import annotations

import pytest

from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.parser import COMMANDS


def test_completion_scripts_name_the_commands(capsys):
    pytest.importorskip("shtab")
    assert main(["completion", "bash"]) == 0
    out = capsys.readouterr().out
    assert all(command.name in out for command in COMMANDS)
