"""Maps beside those of another version: mean angle differences in degrees, and CPU seconds.

    python -m benchmarks versions CHECKOUT MESH|FOLDER ... [--turns 2] [--csv FILE] [--polish angles]

CHECKOUT is a checkout of the other version; of a FOLDER, such as those of `gather`, all meshes are taken. The two take
turns, each in a process of its own with one thread, after a warm-up; of all turns of a version the fastest counts.
Prints the tables of docs/repair.md; FILE gets a row a mesh. A map is worse, or better, if its mean is off by more than
5 percent and .02 degrees.
"""

from __future__ import annotations

import csv
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import igl_spheremap as ism

from .common import ROOT, in_process, load, parser, quality, timed

#: Vertices at which the rows of the table begin.
_FROM = (0, 200, 1000, 4000)


@dataclass(frozen=True)
class Row:
    """A mesh mapped by both versions."""

    mesh: str
    vertices: int
    mean_before: float
    mean: float
    cpu_before: float
    cpu: float
    certified: bool


def main(argv: list[str]) -> None:
    """Print the table, or what the maps of this version are as JSON."""
    arguments = parser(__doc__)
    arguments.add_argument("checkout", type=Path)
    arguments.add_argument("sources", nargs="+")
    arguments.add_argument("--turns", type=int, default=2, help="of each version (2); 0: only map, and print JSON")
    arguments.add_argument("--csv", type=Path, help="write a row for each mesh")
    arguments.add_argument("--polish", choices=("auto", "angles"), default="auto")
    options = arguments.parse_args(argv)
    sources = [str(path) for source in options.sources for path in meshes(source)]
    if not options.turns:
        print(json.dumps(maps(sources, options.polish)))
        return
    runs: dict[Path, list[dict[str, list[float]]]] = {options.checkout: [], ROOT: []}
    for _ in range(options.turns):
        for version, done in runs.items():
            found = in_process("versions", version, *sources, "--turns", 0, "--polish", options.polish, package=version)
            if "failure" in found:
                raise SystemExit(f"{version}: {found['failure']}")
            done.append(found)
    report(rows(sources, *runs.values()), options.csv)


def meshes(source: str) -> list[str | Path]:
    """A mesh, or those of a folder."""
    folder = Path(source)
    return sorted(path for path in folder.rglob("*.*") if path.is_file()) if folder.is_dir() else [source]


def maps(sources: list[str], polish: str) -> dict[str, tuple[float, float, int, bool]]:
    """Mean angle difference, CPU seconds, vertices and certificate of each mesh's map, after a warm-up."""
    ism.spherical_conformal_map(*ism.samples.make("octopus", n_vertices=1500))
    found = {}
    for source in sources:
        v, f = load(source)
        result, cpu = timed(lambda v=v, f=f: ism.spherical_conformal_map(v, f, method=ism.Auto(polish=polish)))  # type: ignore
        measured = quality(v, f, result.sphere)
        found[source] = (measured["mean"], cpu, len(v), not measured["foldings"])
    return found


def rows(sources: list[str], *runs: list[dict[str, list[float]]]) -> list[Row]:
    """What both versions made of each mesh, at their fastest."""
    best = [[min((run[source] for run in done), key=lambda one: one[1]) for done in runs] for source in sources]
    return [Row(Path(source).stem, int(new[2]), old[0], new[0], old[1], new[1], bool(new[3]))
            for source, (old, new) in zip(sources, best, strict=True)]


def report(found: list[Row], file: Path | None) -> None:
    """Print sums, counts and times by the number of vertices, and write the rows to a file."""
    if file is not None:
        with file.open("w", newline="") as opened:
            table = csv.writer(opened, lineterminator="\n")
            table.writerow(Row.__dataclass_fields__)
            for row in found:
                figures = (f"{figure:.3f}" for figure in (row.mean_before, row.mean, row.cpu_before, row.cpu))
                table.writerow((row.mesh, row.vertices, *figures, row.certified))
    print("| vertices | meshes | sum of means | now | worse / better | CPU ratio: median, 90 %, of sums | certified |")
    print("|---|---:|---:|---:|---:|---:|---:|")
    parts = [[row for row in found if low <= row.vertices < high]
             for low, high in zip(_FROM, (*_FROM[1:], np.inf), strict=True)]
    for low, part in [*zip(_FROM, parts, strict=True), ("all", found)]:
        if part:
            print(summary(f"from {low}" if part is not found else "all", part))


def summary(name: str, found: list[Row]) -> str:
    """A row of the table."""
    before, now, cpu_before, cpu = np.array([(r.mean_before, r.mean, r.cpu_before, r.cpu) for r in found]).T
    worse, better = ((a > np.maximum(1.05 * b, b + 0.02)).sum() for a, b in ((now, before), (before, now)))
    ratio = cpu / cpu_before
    median, ninth = np.percentile(ratio, [50, 90])
    return (f"| {name} | {len(found)} | {before.sum():.1f} | {now.sum():.1f} | {worse} / {better} | "
            f"{median:.2f}, {ninth:.2f}, {cpu.sum() / cpu_before.sum():.2f} | {sum(r.certified for r in found)} |")
