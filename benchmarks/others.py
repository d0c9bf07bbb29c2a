"""The comparisons with other programs in one table, each figure read from the file or page that it was measured for.

    python -m benchmarks others [--first N | --once]

`--first` prints the first rows only, for README. `--once` prints what was measured once of programs that are not Python
packages, benchmarks/results/once.tsv.
"""

from __future__ import annotations

import csv
import statistics
from collections.abc import Iterator

from .common import DOCS, ROOT, parser

RESULTS = ROOT / "benchmarks" / "results"


def cells(table: str, row: str) -> list[str]:
    """The cells of the first row that begins so, after its name."""
    line = next(line for line in table.splitlines() if line.startswith(f"| {row} |"))
    return [cell.strip() for cell in line.strip("|").split("|")[1:]]


def kept(name: str, row: str) -> list[str]:
    """The same of a table that a benchmark made."""
    return cells((RESULTS / f"{name}.md").read_text("utf-8"), row)


def peers(row: str) -> list[str]:
    """The same of the table of the largest cortex that LaPy maps."""
    return cells(
        (DOCS / "benchmarks.md").read_text("utf-8").partition(", 163,842 vertices")[2], row
    )


def once(program: str, mesh: str) -> dict[str, str]:
    """Figures that were measured once."""
    with (RESULTS / "once.tsv").open(encoding="utf-8", newline="") as file:
        return next(
            row
            for row in csv.DictReader(file, delimiter="\t")
            if (row["program"], row["mesh"]) == (program, mesh)
        )


def median(column: int) -> str:
    """The median over the cells in `harmonics_bodies`."""
    return f"{statistics.median(float(kept('harmonics_bodies', f'cell {k}')[column]) for k in range(1, 6)):.3g} percent"


def rows() -> Iterator[tuple[str, str, str, str]]:
    """Program, what was measured, its figure, ours."""
    here, lapy = peers("ours, scipy"), peers("LaPy, no refusals")
    mesh = "CPU time, cortex of 163,842 vertices"
    yield (
        "LaPy by scipy, its check for small areas off; here by scipy",
        mesh,
        f"{lapy[0]} s",
        f"{here[0]} s",
    )
    fast, rslab, cvxopt = (
        f"{peers(name)[0]} s" for name in ("LaPy, cholespy", "ours, rslab", "ours, cvxopt")
    )
    yield (
        "LaPy by cholespy; here by rslab, or by cvxopt",
        mesh,
        fast,
        f"{rslab}, or {cvxopt}",
    )
    programs = [
        kept("repair_programs", name)[0] for name in ("LaPy's linear method", "this package")
    ]
    yield "LaPy", "maps without foldings, of 29 surfaces", *programs
    yield "LaPy", "mean angle difference on that cortex", f"{lapy[3]} degrees", f"{here[3]} degrees"
    sdem, (area, angles) = (
        once("SDEM", "choi_maxplanck"),
        kept("balance_programs", "choi_maxplanck | balance 1")[1:3],
    )
    yield (
        "SDEM, of Max Planck",
        "mean angle difference / log area ratio",
        f"{sdem['angles']} degrees / {sdem['log_area']}",
        f"{angles} degrees / {float(area):.2g}",
    )
    lengths = {
        name: kept("balance_lengths", name)
        for name in ("`balance=0.85`", "cat-surf's, relaxed", "FreeSurfer's, in nilearn")
    }
    for program, name in (
        ("cat-surf's relaxed sphere of fsaverage5", "cat-surf's, relaxed"),
        ("FreeSurfer's sphere of fsaverage5", "FreeSurfer's, in nilearn"),
    ):
        yield (
            program,
            "mean angle difference / log area / log edge",
            *(
                f"{found[1]} degrees / {found[0]} / {found[2]}"
                for found in (lengths[name], lengths["`balance=0.85`"])
            ),
        )
    flat = kept("disks_cortex", "`flatten`")
    for program, name in (
        ("FreeSurfer's flat maps of fsaverage5", "FreeSurfer's flat maps (in nilearn; hours)"),
        ("SLIM in libigl, the same cut surfaces", "SLIM of libigl, 20 steps"),
    ):
        yield (
            program,
            "mean angle difference / log area ratio",
            *(f"{found[4]} degrees / {found[5]}" for found in (kept("disks_cortex", name), flat)),
        )
    program = "cat-surf 1.1.6 as T1Prep runs it"
    yield (
        program,
        "registration of an average cortex: median distance from the truth / CPU time",
        *(
            f"{found[0].split(' / ')[0]} mm / {found[5].split(' / ')[0]} s"
            for found in (
                kept("cortices", program),
                kept("cortices", "`register`, 37,000 vertices"),
            )
        ),
    )
    yield (
        "FlowShape",
        "five cells in harmonics to degree 15: distance in units of the diagonal",
        median(3),
        median(7),
    )
    yield "aics-shparam", "the same", median(4), median(7)


def measured_once() -> Iterator[tuple[str, ...]]:
    """A row for each mesh, a column for each program."""
    with (RESULTS / "once.tsv").open(encoding="utf-8", newline="") as file:
        found = [row for row in csv.DictReader(file, delimiter="\t") if not row["log_area"]]
    programs = list(dict.fromkeys(row["program"] for row in found))
    yield "mesh (vertices)", *programs
    for mesh in dict.fromkeys(f"{row['mesh']} ({row['vertices']})" for row in found):
        line = [row for row in found if mesh == f"{row['mesh']} ({row['vertices']})"]
        yield (
            mesh,
            *(
                f"{row['seconds']} / {row['folded']} / {row['angles']}"
                if row["seconds"]
                else "not finite"
                for row in line
            ),
        )


def main(argv: list[str]) -> None:
    """Print the table."""
    arguments = parser(__doc__)
    arguments.add_argument("--first", type=int)
    arguments.add_argument("--once", action="store_true")
    options = arguments.parse_args(argv)
    if options.once:
        header, *lines = measured_once()
        align = "---|" * len(header)
    else:
        header, lines = ("program", "measured", "theirs", "here"), list(rows())[: options.first]
        align = "---|---|---:|---:|"
    print(
        "\n".join(
            [
                f"| {' | '.join(header)} |",
                f"|{align}",
                *(f"| {' | '.join(line)} |" for line in lines),
            ]
        )
    )
