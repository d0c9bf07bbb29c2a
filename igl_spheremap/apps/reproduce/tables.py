"""Tables 1 to 3 as Markdown, each row beside the paper's."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from .measures import mean_angle, to_common_energy
from .paper import TABLE_1, TABLE_2, TABLE_3
from .runs import Outcome, Runs
from .surfaces import Surface, load_surface

_NOTE = """\
Seconds are CPU time, everything included. "paper" columns are quoted from the paper, measured on its machine
with its programs; only ratios compare. "Algorithm 1" is method "lai2014" without folding removal, "Algorithm
2" with it, "Gu-Yau" is method "gu-yau" from the Gauss map as in the paper's comparison, "fast" is the default
method. Each run ends by its own stopping rule; "to one energy" compares the two down to the lowest energy
that both reach. A dagger marks a run that met its cap of iterations.
"""


def table_1(runs: Runs, folder: Path | None) -> str:
    """Table 1: Algorithm 1 from the Gauss map.

    Parameters
    ----------
    runs : Runs
        Computes or recalls.
    folder : Path, optional
        Folder of meshes.

    Returns
    -------
    str
        Markdown.
    """
    lines = []
    for row in TABLE_1:
        surface = load_surface(row.surface, folder)
        ours, fast = runs.get(surface, "Algorithm 1"), runs.get(surface, "fast")
        lines.append(
            [
                *_what(row.surface, row.vertices, surface),
                f"{_iterations(ours)} ({row.iterations[0]})",
                f"{_seconds(ours.seconds)} ({row.seconds})",
                f"{ours.energy:.5f}",
                f"{mean_angle(surface, ours):.2f}",
                str(ours.foldings),
                *_fast(surface, fast),
            ]
        )
    head = [
        "surface",
        "what it is here",
        "vertices (paper)",
        "iterations (paper)",
        "seconds (paper)",
        "energy",
        "mean angle difference",
        "foldings",
        "fast: seconds, foldings",
        "fast: mean angle",
    ]
    return _page("Table 1. Algorithm 1 from the Gauss map", head, lines)


def table_2(runs: Runs, folder: Path | None) -> str:
    """Table 2: Algorithm 1 and the algorithm of Gu and Yau.

    Parameters
    ----------
    runs : Runs
        Computes or recalls.
    folder : Path, optional
        Folder of meshes.

    Returns
    -------
    str
        Markdown.
    """
    lines = []
    for row in TABLE_2:
        surface = load_surface(row.surface, folder)
        ours, theirs = runs.get(surface, "Algorithm 1"), runs.get(surface, "Gu-Yau")
        fast = runs.get(surface, "fast")
        lines.append(
            [
                *_what(row.surface, row.vertices, surface),
                f"{_iterations(ours)} ({row.iterations[0]})",
                f"{_seconds(ours.seconds)} ({row.seconds})",
                f"{_iterations(theirs)} ({row.their_iterations})",
                f"{_seconds(theirs.seconds)} ({row.their_seconds})",
                f"{_ratio(theirs.seconds, ours.seconds)} ({_number(row.ratio)})",
                _common(ours, theirs),
                f"{ours.foldings} / {theirs.foldings}",
                f"{mean_angle(surface, ours):.2f} / {mean_angle(surface, theirs):.2f}",
                *_fast(surface, fast),
            ]
        )
    head = [
        "surface",
        "what it is here",
        "vertices (paper)",
        "Algorithm 1: iterations (paper)",
        "seconds (paper)",
        "Gu-Yau: iterations (paper)",
        "seconds (paper)",
        "ratio of seconds (paper)",
        "to one energy: iterations, seconds, ratio",
        "foldings: Algorithm 1 / Gu-Yau",
        "mean angle: Algorithm 1 / Gu-Yau",
        "fast: seconds, foldings",
        "fast: mean angle",
    ]
    return _page("Table 2. Algorithm 1 and the algorithm of Gu and Yau", head, lines)


def table_3(runs: Runs, folder: Path | None) -> str:
    """Table 3: Algorithm 2, step by step, and the algorithm of Gu and Yau.

    Parameters
    ----------
    runs : Runs
        Computes or recalls.
    folder : Path, optional
        Folder of meshes.

    Returns
    -------
    str
        Markdown.
    """
    lines = []
    for row in TABLE_3:
        surface = load_surface(row.surface, folder)
        ours, theirs = runs.get(surface, "Algorithm 2"), runs.get(surface, "Gu-Yau")
        fast = runs.get(surface, "fast")
        lines.append(
            [
                *_what(row.surface, row.vertices, surface),
                f"{_steps(ours)} ({', '.join(map(str, row.iterations))})",
                ", ".join(f"{entry['foldings_before']} -> {entry['foldings_after']}" for entry in ours.rounds),
                f"{_seconds(ours.seconds)} ({_number(row.seconds)})",
                f"{_iterations(theirs)} ({_number(row.their_iterations)})",
                f"{_seconds(theirs.seconds)} ({_number(row.their_seconds)})",
                f"{_ratio(theirs.seconds, ours.seconds)} ({_number(row.ratio)})",
                f"{ours.foldings} / {theirs.foldings}",
                f"{mean_angle(surface, ours):.2f} / {mean_angle(surface, theirs):.2f}",
                *_fast(surface, fast),
            ]
        )
    head = [
        "surface",
        "what it is here",
        "vertices (paper)",
        "Algorithm 2: iterations by step (paper)",
        "foldings before -> after each step",
        "seconds (paper)",
        "Gu-Yau: iterations (paper)",
        "seconds (paper)",
        "ratio of seconds (paper)",
        "foldings left: Algorithm 2 / Gu-Yau",
        "mean angle: Algorithm 2 / Gu-Yau",
        "fast: seconds, foldings",
        "fast: mean angle",
    ]
    return _page("Table 3. Algorithm 2 and the algorithm of Gu and Yau", head, lines)


def _page(title: str, head: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    table = "\n".join(f"| {' | '.join(line)} |" for line in [head, ["---"] * len(head), *lines])
    return f"# {title}\n\n{_NOTE}\n{table}\n"


def _iterations(outcome: Outcome) -> str:
    return f"{outcome.iterations}{_dagger(outcome.status)}"


def _steps(outcome: Outcome) -> str:
    return ", ".join(f"{entry['iterations']}{_dagger(entry['status'])}" for entry in outcome.rounds)


def _dagger(status: str) -> str:
    return "†" if status == "MAX_ITERATIONS" else ""


def _common(ours: Outcome, theirs: Outcome) -> str:
    common = to_common_energy(ours, theirs)
    if common is None:
        return "-"
    (a, s), (b, t) = common
    return f"{a} / {b}, {_seconds(s)} / {_seconds(t)}, {_ratio(t, s)}"


def _what(name: str, vertices: int, surface: Surface) -> list[str]:
    """The first cells of a line: the paper's surface, what stands for it, and the vertices of both."""
    return [name, f"{surface.source}: {surface.relation}", f"{len(surface.v)} ({vertices})"]


def _fast(surface: Surface, outcome: Outcome) -> list[str]:
    """The last cells of a line: what the fast method makes of the surface."""
    told = outcome.status if outcome.foldings < 0 else f"{_seconds(outcome.seconds)}, {outcome.foldings}"
    return [told, f"{mean_angle(surface, outcome):.2f}"]


def _seconds(seconds: float) -> str:
    return f"{seconds:.3g}" if seconds < 100 else f"{seconds:.0f}"


def _ratio(long: float, short: float) -> str:
    return f"{long / short:.2g}" if short > 0 else "-"


def _number(value: float | None) -> str:
    return "not given" if value is None or math.isnan(value) else f"{value:.4g}"
