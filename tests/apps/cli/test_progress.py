"""Progress: at once on a terminal, gone at the end, nothing in files."""

from __future__ import annotations

import io
import math
import os
import struct
import sys

import numpy as np
import pytest
from shell import SAMPLE

from igl_spheremap import samples
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.progress import Progress, measures
from igl_spheremap.result.run import Iterate, Stage
from igl_spheremap.timings import counted


class Terminal(io.StringIO):
    """A stream that passes for a terminal."""

    def isatty(self) -> bool:
        return True


def as_stderr(stream, monkeypatch):
    """Not a fixture: pytest puts its own stderr back between a fixture and its test."""
    monkeypatch.setattr(sys, "stderr", stream)
    return stream


def screen(text: str) -> str:
    """The last line of a text on a terminal."""
    shown = ""
    for part in text.rpartition("\n")[2].split("\r"):
        shown = part + shown[len(part) :]
    return shown.rstrip()


def test_stages_are_shown_at_once_and_cleared(monkeypatch):
    terminal = as_stderr(Terminal(), monkeypatch)
    with Progress() as progress:
        progress.begin("reading bunny.ply")
        assert screen(terminal.getvalue()).startswith("reading bunny.ply")
        progress.count("mapping", 4)
        assert screen(terminal.getvalue()).startswith("mapping [")
        progress.write("a line that stays")
        assert terminal.getvalue().count("a line that stays\n") == 1
    assert screen(terminal.getvalue()) == ""


def test_iterates_show_what_they_are(monkeypatch):
    terminal = as_stderr(Terminal(), monkeypatch)
    x, f = samples.sphere(42)
    with Progress() as progress:
        progress.listener(f)(Iterate(Stage.ALGORITHM_1, 0, 7, x, 4 * math.pi + 0.01, 1e-3, 0.5))
        assert screen(terminal.getvalue()).startswith("Algorithm 1, iteration 7")


def test_a_long_loop_shows_the_time_that_is_left(monkeypatch):
    terminal = as_stderr(Terminal(), monkeypatch)
    clock = [100.0]
    monkeypatch.setattr("igl_spheremap.apps.cli.progress.time.monotonic", lambda: clock[0])
    with Progress() as progress:
        progress.begin("expanding bunny.ply")
        for _ in counted("steps", range(4)):
            clock[0] += 10
            assert list(counted("steps within", range(3))) == [0, 1, 2]
        list(counted("short", range(1000)))
        assert "expanding bunny.ply: 25%, 30 s left [" in terminal.getvalue()
        assert "expanding bunny.ply: 75%, 10 s left [" in terminal.getvalue()
        assert screen(terminal.getvalue()).startswith("expanding bunny.ply [")
    assert "33%" not in terminal.getvalue()


def test_a_loop_outside_an_activity_has_its_own_name(monkeypatch):
    log, clock = as_stderr(io.StringIO(), monkeypatch), [100.0]
    monkeypatch.setattr("igl_spheremap.apps.cli.progress.time.monotonic", lambda: clock[0])
    with Progress():
        for _ in counted("registering", range(4)):
            clock[0] += 100
    assert log.getvalue().startswith("igl-spheremap: registering: 25%, 5 min left\n")


@pytest.mark.posix
def test_a_line_ends_where_the_terminal_does(monkeypatch):
    fcntl, termios = (pytest.importorskip(name) for name in ("fcntl", "termios"))
    master, slave = os.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 60, 0, 0))
    with open(slave, "w") as terminal:
        as_stderr(terminal, monkeypatch)
        with Progress() as progress:
            progress.begin("reading " + "long/" * 40 + "bunny.ply")
            shown = os.read(master, 4096).decode()
    os.close(master)
    assert "reading long/long/" in shown
    assert max(map(len, shown.split("\r"))) < 60


def test_measures_are_finite():
    x = np.eye(3)
    assert (
        measures(Iterate(Stage.PRECONDITIONED, 0, 0, x, 4 * math.pi + 0.01, math.inf))
        == "energy 4 pi +1.00e-02"
    )
    assert measures(Iterate(Stage.REPAIR, 0, 0, x, math.nan, 3.0)) == "residual 3.0e+00"


def test_a_map_shows_its_stages_on_a_terminal(monkeypatch, tmp_path):
    terminal = as_stderr(Terminal(), monkeypatch)
    assert main(["map", SAMPLE, str(tmp_path / "a.obj")]) == 0
    stages = (
        "reading",
        "mapping",
        "factorising",
        "Preconditioned Cayley steps",
        "certifying",
        "writing",
    )
    places = [terminal.getvalue().index(stage) for stage in stages]
    assert places == sorted(places)
    assert screen(terminal.getvalue()) == ""


@pytest.mark.parametrize("quiet", [False, True])
def test_nothing_is_shown_in_files_or_when_quiet(quiet, monkeypatch):
    stream = as_stderr(Terminal() if quiet else io.StringIO(), monkeypatch)
    with Progress(quiet=quiet) as progress:
        progress.begin("reading bunny.ply")
        progress.count("mapping", 4)(True, False)
    assert stream.getvalue() == ""


def test_the_line_says_how_many_failed(monkeypatch):
    terminal = as_stderr(Terminal(), monkeypatch)
    with Progress() as progress:
        take = progress.count("mapping", 4)
        take(True, False)
        take(True, False)
        take(False, False)
        assert screen(terminal.getvalue()).startswith("mapping: 3 of 4 files done, 1 failed; ")


@pytest.fixture
def log(monkeypatch):
    """A log, and the clock by which lines come into it."""
    clock = [0.0]
    monkeypatch.setattr("igl_spheremap.apps.cli.progress.time.monotonic", lambda: clock[0])
    return as_stderr(io.StringIO(), monkeypatch), clock


def test_a_log_has_a_line_a_minute(monkeypatch, log):
    stream, clock = log
    as_stderr(stream, monkeypatch)
    with Progress() as progress:
        take = progress.count("mapping", 10)
        for seconds, certified, made_before in (
            (1, True, True),  # of an earlier run: it counts as done, not for the rate
            (59, True, False),
            (120, False, False),
            (150, True, False),
            (300, True, False),
        ):
            clock[0] = seconds
            take(certified, made_before)
    assert stream.getvalue().splitlines() == [
        "igl-spheremap: mapping: 3 of 10 files done, 1 failed; 1 a minute, 7 min left",
        "igl-spheremap: mapping: 5 of 10 files done, 1 failed; 0.8 a minute, 7 min left",
    ]


def test_a_log_of_one_map_has_a_line_a_minute_too(monkeypatch, log):
    """Of activities, of iterates and of loops, whichever comes when it is due."""
    stream, clock = log
    as_stderr(stream, monkeypatch)
    x, f = samples.sphere(42)
    with Progress() as progress:
        progress.begin("reading bunny.ply")
        clock[0] = 61
        progress.begin("mapping bunny.ply")
        show = progress.listener(f)
        for k in range(60):
            clock[0] += 2
            show(Iterate(Stage.ALGORITHM_1, 0, k, x, 4 * math.pi + 0.01, 1e-3, 0.5))
        for _ in counted("steps", range(4)):
            clock[0] += 70
    lines = [line.removeprefix("igl-spheremap: ") for line in stream.getvalue().splitlines()]
    assert [line.partition(":")[0].partition(",")[0] for line in lines] == [
        "mapping bunny.ply",
        "Algorithm 1",
        "Algorithm 1",
        *["mapping bunny.ply"] * 3,
    ]
    assert "iteration 29, foldings 0, energy 4 pi +1.00e-02" in lines[1]
    assert lines[-1] == "mapping bunny.ply: 75%, 2 min left"


def test_a_line_in_a_log_needs_no_tqdm(monkeypatch):
    """A second Ctrl-C within tqdm's own way to write ended in a traceback: its lock was not there yet."""
    log = as_stderr(io.StringIO(), monkeypatch)
    monkeypatch.setattr("igl_spheremap.apps.cli.progress.tqdm.write", None)
    with Progress() as progress:
        progress.count("mapping", 4)
        progress.write("finishing")
    assert log.getvalue() == "finishing\n"
