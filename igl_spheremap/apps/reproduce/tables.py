"""Tables 1 to 3: the paper's numbers, and those of its algorithms as printed and made safe, and of the default."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .runs import Outcome, PaperRun, Runs, to_common_energy
from .surfaces import PaperSurface


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


@dataclass(frozen=True)
class Table:
    """A table that can be written: what it is, how to read it, its rows, and what follows from them."""

    title: str
    note: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    findings: Sequence[str] = ()

    def __str__(self) -> str:
        lines = [f"| {' | '.join(each)} |" for each in [self.head, ["---"] * len(self.head), *self.rows]]
        return "\n\n".join([f"# {self.title}", self.note.strip(), "\n".join(lines), *self.findings]) + "\n"


#: Ways to run an algorithm, as rows of a table have them.
_PRINTED, _SAFE = "as printed", "made safe"
_METRIC, _DELAUNAY = "made safe, Laplacian's metric", "made safe, Delaunay weights"
_GU_YAU, _DEFAULT = "Gu-Yau", "default"
#: Why a minimisation ended, by the name of its status.
_ENDS = {"CONVERGED": "rule met", "PLATEAU": "plateau", "MAX_ITERATIONS": "cap", "STALLED": "no step",
         "COLLAPSED": "collapsed"}

_NOTE = """\
"As printed" is `Lai2014.as_printed()`, without safeguards, which ends at a gradient of 1e-10 or after 5,000 iterations;
"made safe" is `Lai2014()`; "default" is the default method, which the paper does not have. "Rule met": the stopping
rule was met (1e-10 as printed, 1e-3 made safe); "plateau": the energy fell by less than 5e-7 of itself in 100
iterations; "cap": the most iterations allowed; "no step": no step was acceptable. Seconds are CPU time of one thread,
everything included; the paper's are those of its machine and programs, so that only ratios compare.
"""


@dataclass(frozen=True)
class Line:
    """What the rows of a surface are made of: the paper's row, the surface that stands for its own, and the runs."""

    paper: PaperRow
    surface: PaperSurface
    runs: Runs
    algorithm: str

    def run_name(self, way: str) -> str:
        """The name of a run in `METHODS`."""
        return way if way in (_GU_YAU, _DEFAULT) else f"{self.algorithm} {way}"

    def planned(self, ways: Sequence[str]) -> Iterator[PaperRun]:
        """All runs that the rows are made of, copies included."""
        for way in ways:
            for copy in range(self.runs.copies + 1 if way in _SPREAD else 1):
                yield self.runs.plan(self.surface, self.run_name(way), copy=copy)

    def outcome(self, way: str) -> Outcome:
        """A run on the surface."""
        return self.runs.get(self.surface, self.run_name(way))

    def spread(self, way: str) -> list[Outcome]:
        """The run, and those on renumbered copies."""
        found = self.runs.spread(self.surface, self.run_name(way)) if way in _SPREAD else [self.outcome(way)]
        # The default method's rounds are repairs, and not those of Algorithm 2.
        return [replace(one, rounds=[]) for one in found] if way == _DEFAULT else found

    @property
    def name(self) -> str:
        """The surface, where it is from and its size."""
        return f"{self.surface.name}: {self.surface.source}, {len(self.surface.v):,} vertices"


#: What is repeated on renumbered copies. Gu and Yau's fixed steps do not amplify rounding.
_SPREAD = (_PRINTED, _SAFE, _DEFAULT)


def lines(runs: Runs, rows: Sequence[PaperRow], algorithm: str) -> list[Line]:
    """The lines of a table; in Table 3 with the sample of the dinosaur and the putamen beside the paper's surfaces."""
    found = [Line(row, runs.surface(row.surface), runs, algorithm) for row in rows]
    if rows is TABLE_3:
        extra = [("Dino", runs.surface("Dino", sample=True)), ("Putamen", runs.surface("Putamen"))]
        digests = {line.surface.digest for line in found}
        found += [Line(PaperRow(name, 0, (), None), surface, runs, algorithm) for name, surface in extra
                  if surface.digest not in digests]
    return found


def table_1(runs: Runs) -> Table:
    """Algorithm 1 on three surfaces."""
    rows: list[list[str]] = []
    found = lines(runs, TABLE_1, "Algorithm 1")
    for line in found:
        paper = line.paper
        rows.append([line.name, f"the paper, {paper.vertices:,} vertices", f"{paper.iterations[0]:,}", "", "", "",
                     f"{paper.seconds:.2f}", ""])
        for way in _WAYS_1:
            outcomes = line.spread(way)
            one = outcomes[0]
            rows.append(["", way, _counts(outcomes, lambda one: one.iterations), f"{one.energy:.5f}", _angle(one),
                         _counts(outcomes, lambda one: one.foldings), _seconds(one.seconds), _ended(one)])
    head = ("surface", "algorithm", "iterations", "energy", "mean angle", "folded faces", "seconds", "ended by")
    return Table("Table 1. Algorithm 1 from the Gauss map", _NOTE + _tolerance(found, _WAYS_1), head, rows)


_WAYS_1 = (_PRINTED, _SAFE, _DEFAULT)
_WAYS_2 = (_PRINTED, _SAFE, _METRIC, _GU_YAU, _DEFAULT)
_WAYS_3 = (_PRINTED, _SAFE, _METRIC, _DELAUNAY, _GU_YAU, _DEFAULT)


def table_2(runs: Runs) -> Table:
    """Algorithm 1 and the algorithm of Gu and Yau on seven surfaces."""
    rows: list[list[str]] = []
    found = lines(runs, TABLE_2, "Algorithm 1")
    for line in found:
        paper = line.paper
        rows.append([line.name, f"the paper, {paper.vertices:,} vertices", f"{paper.iterations[0]:,}",
                     f"{paper.seconds:.2f}", f"{paper.ratio:.0f}", "", "", "", ""])
        rows.append(["", "the paper: Gu-Yau", f"{paper.their_iterations:,}", f"{paper.their_seconds:.2f}", *[""] * 5])
        theirs = line.outcome(_GU_YAU)
        for way in _WAYS_2:
            outcomes = line.spread(way)
            one = outcomes[0]
            compared = way not in (_GU_YAU, _DEFAULT)
            rows.append(["", way, _counts(outcomes, lambda one: one.iterations), _seconds(one.seconds),
                         "" if way == _GU_YAU else _ratio(theirs.seconds, one.seconds),
                         _common(one, theirs) if compared else "", _angle(one),
                         _counts(outcomes, lambda one: one.foldings), _ended(one)])
    head = ("surface", "algorithm", "iterations", "seconds", "Gu-Yau's seconds over these",
            "to one energy: iterations / Gu-Yau's, ratio of seconds", "mean angle", "folded faces", "ended by")
    note = """\
Terms are those of Table 1. "Gu-Yau" is method "gu-yau" from the Gauss map; it ends by the rules of "made safe", or
after 20,000 iterations.
"Laplacian's metric" divides by sums of the Laplacian's rows, `Lai2014(metric="laplacian")`, in place of areas, eqs. (9)
and (13). Each run ends by its own rule; "to one energy" compares two down to the lowest energy that both reach.
"""
    return Table("Table 2. Algorithm 1 and the algorithm of Gu and Yau", note + _tolerance(found, _WAYS_2), head, rows,
                 [_speed(found)])


def table_3(runs: Runs) -> Table:
    """Algorithm 2 and the algorithm of Gu and Yau on surfaces with long, sharp features."""
    rows: list[list[str]] = []
    found = lines(runs, TABLE_3, "Algorithm 2")
    for line in found:
        paper = line.paper
        if paper.vertices:
            rows.append([line.name, f"the paper, {paper.vertices:,} vertices", _listed(paper.iterations), "", "0", "",
                         "", "not given" if paper.seconds is None else f"{paper.seconds:.2f}", ""])
        for way in _WAYS_3:
            outcomes = line.spread(way)
            one = outcomes[0]
            rows.append(["" if paper.vertices or way != _WAYS_3[0] else line.name, way, _steps(outcomes), _course(one),
                         _counts(outcomes, lambda one: one.foldings), f"{max(one.energy, 0.0):.4f}", _angle(one),
                         _seconds(one.seconds), _ended(one)])
    head = ("surface", "algorithm", "iterations by step", "folded faces before → after each step", "left",
            "energy", "mean angle", "seconds", "ended by")
    note = """\
Terms are those of Tables 1 and 2. "Delaunay weights" are those of the intrinsic Delaunay triangulation,
`Lai2014(edge_weights="delaunay")`. As printed and made safe a run has at most three eigen-projections.
"""
    return Table("Table 3. Algorithm 2 and the algorithm of Gu and Yau", note + _tolerance(found, _WAYS_3), head, rows,
                 _removal(found))


def _removal(found: Sequence[Line]) -> list[str]:
    """Where folded faces are gone and where not, in sentences."""
    left = {way: {line.surface.label: line.outcome(way).foldings for line in found} for way in _WAYS_3}
    clean = {way: {name for name, count in counts.items() if count == 0} for way, counts in left.items()}
    spread = {way: {line.surface.label for line in found if all(one.foldings == 0 for one in line.spread(way))}
              for way in (_PRINTED, _SAFE)}
    needed = [name for name in left[_SAFE] if name in clean[_SAFE] - clean[_PRINTED]]
    both = [name for name in left[_SAFE] if name in spread[_PRINTED]]
    findings = [f"**Where the paper's claim needs the safeguards.** \"Our code always removed all the foldings\" "
                f"holds as printed on {_names(both)}; it needs the safeguards on {_names(needed)}."]
    points = [line.surface.label for line in found if line.outcome(_PRINTED).energy < 2 * np.pi]
    findings.append(f"**Where it collapses.** As printed the map ends at the constant map, of energy 0, on "
                    f"{_names(points)}.")
    fails = [name for name in left[_SAFE] if name not in clean[_SAFE]]
    findings.append(f"**Where it fails with them, too.** On {_names(fails)}.")
    return findings


def _names(names: Sequence[str]) -> str:
    return " and ".join(filter(None, [", ".join(names[:-1]), *names[-1:]])) or "none of these surfaces"


def _speed(found: Sequence[Line]) -> str:
    """How Algorithm 1 compares with the algorithm of Gu and Yau, in a sentence for each way to run it."""
    parts = []
    for way in (_PRINTED, _SAFE, _METRIC):
        pairs = [to_common_energy(line.outcome(way), line.outcome(_GU_YAU)) for line in found]
        ratios = [theirs[0] / max(ours[0], 1) for ours, theirs in filter(None, pairs)]
        seconds = [theirs[1] / max(ours[1], 1e-3) for ours, theirs in filter(None, pairs)]
        if ratios:
            factors = [f"{min(each):.1f} to {max(each):.1f} ({np.median(each):.1f})" for each in (ratios, seconds)]
            parts.append(f"{way}: {' and '.join(factors)} on {len(ratios)} surfaces")
    paper = [row.their_iterations / row.iterations[0] for row in TABLE_2 if row.their_iterations]
    return (f"**Iterations for one energy.** Gu-Yau's iterations and seconds over those of Algorithm 1, medians in "
            f"brackets: {'; '.join(parts)}. The paper's own counts differ by {min(paper):.1f} to "
            f"{max(paper):.1f} times.")


def _tolerance(found: Sequence[Line], ways: Sequence[str]) -> str:
    """By how much a second machine may differ: as renumbered copies do, where these were run."""
    copies = found[0].runs.copies
    if not copies and ways is not _WAYS_1:
        return ""
    if not copies:
        return ("\nRounding alone changes iterations by up to half of them, and counts of folded faces, where some\n"
                "are left, by up to three quarters (`--spread` measures it): tables of another machine may differ\n"
                "by as much.\n")
    parts = []
    for way in (way for way in ways if way in _SPREAD):
        spreads = [line.spread(way) for line in found]
        iterations = max(_range([one.iterations for one in each]) for each in spreads)
        folds = max(max(one.foldings for one in each) - min(one.foldings for one in each) for each in spreads)
        angles = max(_range([one.mean_angle for one in each]) for each in spreads)
        parts.append(f"{way} {iterations:.0%}, {angles:.0%}, {folds:,}")
    how = (f"In brackets: the range over {copies} renumbered copies, which only rounding changes; another machine may\n"
           "differ by as much. Largest ranges of iterations and mean angle differences, in shares of the median, and\n"
           "of folded faces") if ways is _WAYS_1 else "Largest ranges over renumbered copies, as in Table 1"
    return f"\n{how}: {'; '.join(parts)}.\n"


def _range(values: Sequence[float]) -> float:
    """Largest less least value, in units of the median."""
    middle = float(np.median(values))
    return (max(values) - min(values)) / middle if middle else 0.0


def _counts(outcomes: Sequence[Outcome], count: Callable[[Outcome], int]) -> str:
    """A count, and in brackets its least and largest over renumbered copies, if these differ."""
    numbers = [count(one) for one in outcomes]
    if numbers[0] < 0:
        return "no map"
    bounds = f" ({min(numbers):,} to {max(numbers):,})" if min(numbers) < max(numbers) else ""
    return f"{numbers[0]:,}{bounds}"


def _steps(outcomes: Sequence[Outcome]) -> str:
    """Iterations of each round; with copies, the least and the largest sum."""
    rounds = outcomes[0].rounds
    sums = [one.iterations for one in outcomes]
    bounds = f" (in all {min(sums):,} to {max(sums):,})" if min(sums) < max(sums) else ""
    return f"{_listed([entry['iterations'] for entry in rounds] or [sums[0]])}{bounds}"


def _listed(numbers: Sequence[int]) -> str:
    return ", ".join(f"{number:,}" for number in numbers)


def _course(outcome: Outcome) -> str:
    return ", ".join(f"{entry['foldings_before']:,} → {entry['foldings_after']:,}" for entry in outcome.rounds)


def _ended(outcome: Outcome) -> str:
    """Why each round ended, once if all for one reason; of a method that failed, its message."""
    names = [entry["status"] for entry in outcome.rounds] or [outcome.status]
    return ", ".join(_ENDS.get(name, name) for name in (names if len(set(names)) > 1 else names[:1]))


def _common(ours: Outcome, theirs: Outcome) -> str:
    common = to_common_energy(ours, theirs)
    if common is None:
        return "-"
    (a, s), (b, t) = common
    return f"{a:,} / {b:,}, {_ratio(t, s)}"


def _angle(outcome: Outcome) -> str:
    return f"{outcome.mean_angle:.2f}"


def _seconds(seconds: float) -> str:
    return f"{seconds:.2g}" if seconds < 10 else f"{seconds:.0f}"


def _ratio(long: float, short: float) -> str:
    if short <= 0:
        return "-"
    return f"{long / short:.2g}" if long < 100 * short else f"{long / short:.0f}"


#: What writes the tables, by their names.
TABLES: dict[str, Callable[[Runs], Table]] = {"table1": table_1, "table2": table_2, "table3": table_3}
#: Their rows, the algorithm, and the ways in which it is run.
WAYS = {"table1": (TABLE_1, "Algorithm 1", _WAYS_1), "table2": (TABLE_2, "Algorithm 1", _WAYS_2),
        "table3": (TABLE_3, "Algorithm 2", _WAYS_3)}
