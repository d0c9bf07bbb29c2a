"""Tables 1 to 3: the paper's numbers, and those of its algorithms by this package on other surfaces."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.resources import files

import numpy as np

from ...result.run import Round, Status
from .runs import PaperRun, Runs


@dataclass(frozen=True)
class PaperRow:
    """One row of a table of Lai et al.; None for missing numbers.

    `iterations` are those of each step of Algorithm 2. "Their" algorithm is that of [1], Gu and Yau.
    """

    surface: str
    vertices: int
    iterations: Sequence[int]
    seconds: float | None = None
    their_iterations: int | None = None
    their_seconds: float | None = None

    @property
    def ratio(self) -> str:
        """Seconds of the algorithm in [1] over those of the proposed one."""
        if self.seconds is None or self.their_seconds is None:
            return ""
        return _ratio(self.their_seconds, self.seconds)


_ROWS = json.loads(files(__package__).joinpath("paper_tables.json").read_text(encoding="utf-8"))
TABLE_1, TABLE_2, TABLE_3 = (tuple(PaperRow(**row) for row in rows) for rows in _ROWS.values())


_NOTE = """\
"lai2014" is `Lai2014()`, "as printed" and "as programmed" are its other settings, "gu-yau" the algorithm of Gu and Yau
from the Gauss map, "auto" the default method. The paper's rows are of its own surfaces and machine. Folded faces are
those of each start and of the map that Algorithm 1 makes of it. Mean angle: mean size of the angle differences, in
degrees. Seconds: CPU time of one thread. Ended by: "rule met"; "plateau", the energy hardly fell any more; "cap", the
most iterations allowed; "no step", none was acceptable; "collapsed", the map has degree 0.
"""
#: Why a minimisation ended, by the name of its status.
_ENDS = {
    Status.CONVERGED: "rule met",
    Status.PLATEAU: "plateau",
    Status.MAX_ITERATIONS: "cap",
    Status.STALLED: "no step",
    Status.DONE: "repaired",
    Status.COLLAPSED: "collapsed",
}
_HEAD = (
    "surface",
    "algorithm",
    "iterations",
    "folded faces, before → after",
    "energy",
    "mean angle",
    "ended by",
    "seconds",
    "gu-yau's seconds over these",
)
#: Names in `METHODS` of the rows of a surface; {} is the algorithm.
WAYS = {
    "lai2014": "{}",
    "as printed": "{} as printed",
    "as programmed": "{} as programmed",
    "gu-yau": "Gu-Yau",
    "auto": "auto",
}


def _table(title: str, rows: Sequence[PaperRow], algorithm: str, runs: Runs) -> str:
    """The paper's numbers, and below them those of the surface that stands for its own, as Markdown."""
    compared = any(row.their_iterations for row in rows)
    cells = [
        _HEAD,
        ["---"] * len(_HEAD),
        *(line for row in rows for line in _lines(row, algorithm, runs, compared)),
    ]
    return (
        "\n\n".join(
            [f"# {title}", _NOTE.strip(), "\n".join(f"| {' | '.join(each)} |" for each in cells)]
        )
        + "\n"
    )


def _lines(row: PaperRow, algorithm: str, runs: Runs, compared: bool) -> Iterator[list[str]]:
    """All lines of a surface; in a table that compares with the algorithm of Gu and Yau, its own, too."""
    surface = runs.surface(row.surface)
    folds = ("removed", "remained") if len(row.iterations) > 1 else ("", "")
    yield [
        f"{row.surface}, {row.vertices:,} vertices",
        "the paper",
        _listed(row.iterations),
        folds[0],
        "",
        "",
        "",
        "not given" if row.seconds is None else f"{row.seconds:.2f}",
        row.ratio,
    ]
    if row.their_iterations is not None:
        yield [
            "",
            "the paper: gu-yau",
            f"{row.their_iterations:,}",
            folds[1],
            "",
            "",
            "",
            f"{row.their_seconds:.2f}",
            "",
        ]
    made = {
        way: runs.get(surface, name.format(algorithm))
        for way, name in WAYS.items()
        if compared or way != "gu-yau"
    }
    place = surface.title
    for way, one in made.items():
        theirs = made.get("gu-yau", one)
        yield [
            place,
            way,
            *_cells(way, one),
            "" if theirs is one else _ratio(theirs.seconds, one.seconds),
        ]
        place = ""


def _cells(way: str, one: PaperRun) -> list[str]:
    """Cells of a run."""
    result = one.result
    # The rounds of the default method are repairs, and not those of Algorithm 2.
    rounds = () if way == "auto" else result.rounds
    iterations = [entry.iterations for entry in rounds] or [result.iterations]
    course = [f"{entry.foldings_before:,} → {entry.foldings_after:,}" for entry in rounds]
    return [
        _listed(iterations),
        ", ".join(course) or f"{result.certificate.foldings:,}",
        f"{abs(result.energy):.4f}",
        f"{np.abs(result.angle_differences()).mean():.2f}",
        ended(rounds, result.status),
        _short(one.seconds),
    ]


def ended(rounds: Sequence[Round], status: Status) -> str:
    """Reason for the end of each round, or of a run without rounds; a common reason is said once."""
    ends = [entry.status for entry in rounds] or [status]
    return ", ".join(
        _ENDS.get(end, end.value) for end in (ends if len(set(ends)) > 1 else ends[:1])
    )


def _listed(numbers: Sequence[int]) -> str:
    return ", ".join(f"{number:,}" for number in numbers)


def _short(number: float) -> str:
    """A number with two digits, or with all before the point.

    >>> _short(0.0437), _short(158.4)
    ('0.044', '158')
    """
    if number < 10:
        return f"{number:.2g}"
    return f"{number:.0f}"


def _ratio(theirs: float, ours: float) -> str:
    return _short(theirs / max(ours, 1e-3))


#: Writers of the tables, by their names.
TABLES: dict[str, Callable[[Runs], str]] = {
    "table1": partial(_table, "Table 1. Algorithm 1 from the Gauss map", TABLE_1, "Algorithm 1"),
    "table2": partial(
        _table, "Table 2. Algorithm 1 and the algorithm of Gu and Yau", TABLE_2, "Algorithm 1"
    ),
    "table3": partial(
        _table, "Table 3. Algorithm 2 and the algorithm of Gu and Yau", TABLE_3, "Algorithm 2"
    ),
}
