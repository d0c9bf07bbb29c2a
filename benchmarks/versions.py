"""Maps beside those of another version: mean angle differences in degrees, and CPU seconds.

    python -m benchmarks versions CHECKOUT MESH ... [--turns 2]

CHECKOUT is a checkout of the other version. The two take turns, each in a process of its own with one thread, after a
warm-up; of all turns of a version the fastest counts. Prints a table of docs/repair.md.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

import igl_spheremap as ism

from .common import ROOT, in_process, load, parser, quality, timed


def main(argv: list[str]) -> None:
    """Print the table, or what the maps of this version are as JSON."""
    arguments = parser(__doc__)
    arguments.add_argument("checkout", type=Path)
    arguments.add_argument("sources", nargs="+")
    arguments.add_argument("--turns", type=int, default=2, help="of each version (2); 0: only map, and print JSON")
    options = arguments.parse_args(argv)
    if not options.turns:
        print(json.dumps(maps(options.sources)))
        return
    runs: dict[Path, list[dict[str, list[float]]]] = {options.checkout: [], ROOT: []}
    for _ in range(options.turns):
        for version, done in runs.items():
            found = in_process("versions", version, *options.sources, "--turns", 0, package=version)
            if "failure" in found:
                raise SystemExit(f"{version}: {found['failure']}")
            done.append(found)
    report(options.sources, *runs.values())


def maps(sources: list[str]) -> dict[str, tuple[float, float]]:
    """Mean angle difference and CPU seconds of each mesh's map, after a warm-up."""
    ism.spherical_conformal_map(*ism.samples.make("octopus", n_vertices=1500))
    found = {}
    for source in sources:
        v, f = load(source)
        result, cpu = timed(lambda v=v, f=f: ism.spherical_conformal_map(v, f))  # type: ignore[misc]
        found[source] = (quality(v, f, result.sphere)["mean"], cpu)
    return found


def report(sources: list[str], *runs: list[dict[str, list[float]]]) -> None:
    """Print means and times by the other version and by this one, and how the ratios of times are spread."""
    print("| mesh | mean, the other | here | CPU, the other | here |\n|---|---:|---:|---:|---:|")
    ratios = []
    for source in sources:
        (old, before), (new, now) = (min((run[source] for run in done), key=lambda one: one[1]) for done in runs)
        ratios.append(now / before)
        print(f"| {Path(source).stem} | {old:.2f} | {new:.2f} | {before:.2f} | {now:.2f} |")
    median, ninth, most = np.percentile(ratios, [50, 90, 100])
    print(f"CPU time over the other's: median {median:.2f}, 90th percentile {ninth:.2f}, most {most:.2f}")
