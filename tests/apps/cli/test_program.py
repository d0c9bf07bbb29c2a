"""The command line as a whole: exit statuses, one line per failure, help, and itself as a program."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest
from shell import SAMPLE, one_line

from igl_spheremap import MeshError, samples
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.commands import COMMANDS
from igl_spheremap.apps.cli.commands import map as map_command
from igl_spheremap.apps.cli.parser import build_parser


@pytest.mark.parametrize(
    ("arguments", "status"),
    [
        ([], 64),
        (["frobnicate"], 64),
        (["map", SAMPLE], 64),
        (["map", SAMPLE, "a.obj", "--method", "magic"], 64),
        (["info", "sample:unicorn"], 64),
        (["info", "sample:dino:wings=2"], 64),
        (["info", SAMPLE, "--keep-largest"], 64),
        (["map", SAMPLE, "a.obj", "--radius", "-1"], 64),
        (["map", SAMPLE, "a.npz", "--radius", "2"], 64),
        (["info", "missing.obj"], 74),
        (["map", SAMPLE, "a.xyz"], 74),
        (["map", SAMPLE, "nowhere/a.obj"], 74),
        (["map", SAMPLE, "."], 74),
        (["info", "."], 74),
        (["info", SAMPLE, "--json", "nowhere/a.json"], 74),
    ],
)
def test_every_failure_is_one_line_and_a_status(arguments, status, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == status
    one_line(capsys)
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (MeshError("a\nb"), 2),
        (MemoryError(), 70),
        (KeyboardInterrupt(), 130),
        (OSError(28, "No space left"), 74),
    ],
)
def test_failures_within_are_reported_in_one_line(error, status, tmp_path, monkeypatch, capsys):
    def fail(*_, **__):
        raise error

    monkeypatch.setattr(map_command, "spherical_conformal_map", fail)
    assert main(["map", SAMPLE, str(tmp_path / "a.obj")]) == status
    one_line(capsys)
    assert os.listdir(tmp_path) == []


def test_help_lists_the_samples(capsys):
    assert main(["--help"]) == 0
    assert ", ".join(samples.names()) in capsys.readouterr().out


def test_help_shows_examples_that_parse():
    parser = build_parser()
    for command in COMMANDS:
        for line in command.examples:
            words = line.split(" > ")[0].split()
            assert words[0] == "igl-spheremap"
            assert parser.parse_args(words[1:]).command == command.name


def test_as_a_program(tmp_path):
    run = subprocess.run(
        [sys.executable, "-m", "igl_spheremap", "map", "sample:sphere:n_vertices=42", "a.off"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=100,
    )
    assert (run.returncode, run.stderr) == (0, "")
    assert "certified as written" in run.stdout


def test_summaries_fit_in_80_columns(tmp_path, capsys):
    target = str(tmp_path / "s.npz")
    assert main(["map", SAMPLE, target, "--method", "lai2014"]) == 0
    assert main(["check", SAMPLE, target]) == 0
    assert main(["info", SAMPLE]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if str(tmp_path) not in line]
    assert max(map(len, lines)) <= 80
    assert any(line.split()[:1] == ["round"] for line in lines)


def test_json_on_stdout_is_all_there_is(sphere, capsys):
    assert main(["check", SAMPLE, str(sphere), "--json", "-"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert json.loads(out)["certificate"]["degree"] == 1


def test_quiet_prints_nothing(tmp_path, capsys):
    assert main(["map", SAMPLE, str(tmp_path / "a.ply"), "-q"]) == 0
    assert capsys.readouterr() == ("", "")
