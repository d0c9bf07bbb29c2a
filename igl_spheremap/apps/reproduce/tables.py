"""Tables 1 to 3: the paper's numbers, and ours beside them as Markdown."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from .runs import Outcome, PaperSurface, Runs, to_common_energy


@dataclass(frozen=True)
class PaperRow:
    """One row of a table of Lai et al.; None where the text has no number.

    In Table 3, `iterations` are those of each step of Algorithm 2. "Their" algorithm is that of [1], Gu and Yau.
    """

    surface: str
    vertices: int
    iterations: tuple[int, ...]
    seconds: float | None
    their_iterations: int | None = None
    their_seconds: float | None = None

    @property
    def ratio(self) -> float | None:
        """Seconds of the algorithm in [1] over those of the proposed one."""
        if self.seconds is None or self.their_seconds is None:
            return None
        return self.their_seconds / self.seconds


TABLE_1 = (
    PaperRow("Putamen", 10_000, (1414,), 4.80),
    PaperRow("Brain", 15_002, (1329,), 9.36),
    PaperRow("Maxplanck", 12_556, (892,), 5.19),
)

TABLE_2 = (
    PaperRow("Hippocampus 1", 2_000, (210,), 0.19, 790, 16.91),
    PaperRow("Hippocampus 2", 2_562, (4225,), 5.83, 1594, 108.36),
    PaperRow("Putamen", 10_002, (1414,), 4.80, 2684, 760.33),
    PaperRow("Gray matter", 10_000, (1598,), 5.79, 2794, 822.90),
    PaperRow("Brain", 15_002, (1329,), 9.36, 1560, 664.97),
    PaperRow("Maxplanck", 12_556, (892,), 5.19, 1990, 704.01),
    PaperRow("Bimba", 15_002, (1432,), 17.40, 3197, 1358.72),
)

TABLE_3 = (
    PaperRow("Dino", 5_524, (4480, 1518, 3652), None),
    PaperRow("Dilo", 9_731, (3610, 5000, 4184), 73.94, 3106, 513.56),
    PaperRow("Bird 1", 950, (1054, 4444, 1038), 2.64, 716, 19.29),
    PaperRow("Bird 2", 926, (592, 1674, 5000), 14.44, 599, 14.09),
    PaperRow("Armadillo", 16_519, (4164, 294, 496), 70.68, 3355, 1648.30),
)


_NOTE = """\
Seconds are CPU time, everything included. "paper" columns are quoted from the paper, measured on its machine
with its programs; only ratios compare. "Algorithm 1" is method "lai2014" without folding removal, "Algorithm
2" with it, "with Delaunay weights" the same with weights that are never negative, "Gu-Yau" is method "gu-yau"
from the Gauss map as in the paper's comparison, "fast" is the default method. Each run ends by its own stopping
rule; "to one energy" compares the two down to the lowest energy that both reach. A dagger marks a run that met
its cap of iterations.
"""


@dataclass(frozen=True)
class Line:
    """What a line of a table is made of: the paper's row, the surface that stands for its own, and the runs."""

    paper: PaperRow
    surface: PaperSurface
    runs: Runs

    def outcome(self, method: str) -> Outcome:
        """The run of a method on the surface."""
        return self.runs.get(self.surface, method)

    def both(self, method: str, figure: Callable[[Outcome], str]) -> str:
        """A figure of a method, and that of Gu-Yau."""
        return f"{figure(self.outcome(method))} / {figure(self.outcome('Gu-Yau'))}"

    def angle(self, outcome: Outcome) -> str:
        """Mean size of the angle differences."""
        return f"{outcome.mean_angle(self.surface):.2f}"


#: A title, and what stands under it.
Column = tuple[str, Callable[[Line], str]]

_SURFACE: tuple[Column, ...] = (
    ("surface", lambda line: line.paper.surface),
    ("what it is here", lambda line: f"{line.surface.source}: {line.surface.relation}"),
    ("vertices (paper)", lambda line: f"{len(line.surface.v)} ({line.paper.vertices})"),
)
_FAST: tuple[Column, ...] = (
    ("fast: seconds, foldings", lambda line: _verdict(line.outcome("fast"))),
    ("fast: mean angle", lambda line: line.angle(line.outcome("fast"))),
)


def _beside(title: str, ours: Callable[[Line], str], papers: Callable[[PaperRow], float | str | None]) -> Column:
    """A column with a figure of ours, and the paper's in brackets."""
    return f"{title} (paper)", lambda line: f"{ours(line)} ({_number(papers(line.paper))})"


def _iterations(title: str, method: str) -> Column:
    return _beside(
        title, lambda line: _steps(line.outcome(method)), lambda paper: ", ".join(map(str, paper.iterations))
    )


def _time(method: str) -> Column:
    return _beside("seconds", lambda line: _seconds(line.outcome(method).seconds), lambda paper: paper.seconds)


def _against_gu_yau(method: str) -> tuple[Column, ...]:
    def iterations(line: Line) -> str:
        outcome = line.outcome("Gu-Yau")
        return f"{outcome.iterations}{_dagger(outcome.status)}"

    def ratio(line: Line) -> str:
        return _ratio(line.outcome("Gu-Yau").seconds, line.outcome(method).seconds)

    return (
        _beside("Gu-Yau: iterations", iterations, lambda paper: paper.their_iterations),
        _beside("seconds", lambda line: _seconds(line.outcome("Gu-Yau").seconds), lambda paper: paper.their_seconds),
        _beside("ratio of seconds", ratio, lambda paper: paper.ratio),
        (f"foldings: {method} / Gu-Yau", lambda line: line.both(method, lambda outcome: str(outcome.foldings))),
        (f"mean angle: {method} / Gu-Yau", lambda line: line.both(method, line.angle)),
    )


@dataclass(frozen=True)
class Table:
    """A table of the paper: its title, its rows, and the columns between the surface's and the fast method's."""

    title: str
    rows: Sequence[PaperRow]
    columns: Sequence[Column]

    def page(self, runs: Runs) -> str:
        """The table as Markdown."""
        columns = (*_SURFACE, *self.columns, *_FAST)
        lines = [Line(row, runs.surface(row.surface), runs) for row in self.rows]
        cells = [[cell(line) for _, cell in columns] for line in lines]
        return f"# {self.title}\n\n{_NOTE}\n{markdown([name for name, _ in columns], cells)}"


def markdown(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table."""
    return "\n".join(f"| {' | '.join(each)} |" for each in [head, ["---"] * len(head), *rows]) + "\n"


_TABLES = {
    "table1": Table(
        "Table 1. Algorithm 1 from the Gauss map",
        TABLE_1,
        (
            _iterations("iterations", "Algorithm 1"),
            _time("Algorithm 1"),
            ("energy", lambda line: f"{line.outcome('Algorithm 1').energy:.5f}"),
            ("mean angle difference", lambda line: line.angle(line.outcome("Algorithm 1"))),
            ("foldings", lambda line: str(line.outcome("Algorithm 1").foldings)),
        ),
    ),
    "table2": Table(
        "Table 2. Algorithm 1 and the algorithm of Gu and Yau",
        TABLE_2,
        (
            _iterations("Algorithm 1: iterations", "Algorithm 1"),
            _time("Algorithm 1"),
            *_against_gu_yau("Algorithm 1"),
            (
                "to one energy: iterations, seconds, ratio",
                lambda line: _common(line.outcome("Algorithm 1"), line.outcome("Gu-Yau")),
            ),
        ),
    ),
    "table3": Table(
        "Table 3. Algorithm 2 and the algorithm of Gu and Yau",
        TABLE_3,
        (
            _iterations("Algorithm 2: iterations by step", "Algorithm 2"),
            ("foldings before -> after each step", lambda line: _course(line.outcome("Algorithm 2"))),
            _time("Algorithm 2"),
            ("with Delaunay weights: iterations", lambda line: _steps(line.outcome("Delaunay weights"))),
            ("foldings before -> after each step", lambda line: _course(line.outcome("Delaunay weights"))),
            ("mean angle", lambda line: line.angle(line.outcome("Delaunay weights"))),
            *_against_gu_yau("Algorithm 2"),
        ),
    ),
}
#: The tables as Markdown pages, by their names.
TABLES: dict[str, Callable[[Runs], str]] = {name: table.page for name, table in _TABLES.items()}


def _steps(outcome: Outcome) -> str:
    """Iterations of each round, or of a run without rounds."""
    rounds = outcome.rounds or [{"iterations": outcome.iterations, "status": outcome.status}]
    return ", ".join(f"{entry['iterations']}{_dagger(entry['status'])}" for entry in rounds)


def _dagger(status: str) -> str:
    return "†" if status == "MAX_ITERATIONS" else ""


def _course(outcome: Outcome) -> str:
    return ", ".join(f"{entry['foldings_before']} -> {entry['foldings_after']}" for entry in outcome.rounds)


def _common(ours: Outcome, theirs: Outcome) -> str:
    common = to_common_energy(ours, theirs)
    if common is None:
        return "-"
    (a, s), (b, t) = common
    return f"{a} / {b}, {_seconds(s)} / {_seconds(t)}, {_ratio(t, s)}"


def _verdict(outcome: Outcome) -> str:
    return outcome.status if outcome.foldings < 0 else f"{_seconds(outcome.seconds)}, {outcome.foldings}"


def _seconds(seconds: float) -> str:
    return f"{seconds:.3g}" if seconds < 100 else f"{seconds:.0f}"


def _ratio(long: float, short: float) -> str:
    return f"{long / short:.2g}" if short > 0 else "-"


def _number(value: float | str | None) -> str:
    """A number of the paper; a text stays as it is."""
    return value if isinstance(value, str) else "not given" if value is None else f"{value:.4g}"
