"""CPU time and memory a vertex as meshes are refined.

    python -m benchmarks scaling OPERATION MESH [OPERATION MESH ...] [--levels 2] [--scipy]

OPERATION is "map" or a balance above 0, whose time is without that of the conformal map. MESH is a file or
"sample:SPEC". Each level runs in a process of its own, and is a row of the table. With --scipy no other solver is
found.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

import igl_spheremap as ism

from .common import in_process, load, measured, parser


def main(argv: list[str]) -> None:
    """Print the table of all levels, or the figures of one."""
    arguments = parser(__doc__)
    arguments.add_argument("runs", nargs="+", metavar="OPERATION MESH")
    arguments.add_argument("--levels", type=int, default=2, help="loop subdivisions (2)")
    arguments.add_argument("--only", type=int, help="measure this level in this process")
    arguments.add_argument("--scipy", action="store_true")
    options = arguments.parse_args(argv)
    if options.scipy:
        sys.modules["cvxopt"] = sys.modules["rslab"] = None  # type: ignore[assignment]
    runs = list(zip(options.runs[::2], options.runs[1::2], strict=True))
    if options.only is not None:
        [(operation, source)] = runs
        print(json.dumps(figures(operation, *load(source, options.only)), default=float))
        return
    print(
        "| operation | mesh | vertices | foldings at first | certified | microseconds a vertex | kB a vertex | mean, "
        "degrees |\n|---|---|---:|---:|---|---:|---:|---:|"
    )
    for operation, source in runs:
        name = Path(source).stem.removeprefix("sample:")
        for level in range(options.levels + 1):
            found = in_process(
                "scaling", operation, source, *["--scipy"] * options.scipy, "--only", level
            )
            if "failure" in found:
                raise SystemExit(f"{operation} of {source}: {found['failure']}")
            print(
                f"| {operation} | {name} | {found['vertices']:,} | {found['foldings at first']:,} | "
                f"{'yes' if found['certified'] else 'no'} | {found['microseconds a vertex']:.0f} | "
                f"{found['kB a vertex']:.1f} | {found['mean']:.2f} |",
                flush=True,
            )


def figures(operation: str, v: np.ndarray, f: np.ndarray) -> dict[str, object]:
    """Measures at one level."""
    result, spent = measured(lambda: ism.spherical_conformal_map(v, f))
    folded = result.rounds[0].foldings_after if result.rounds else 0
    if operation != "map":
        result, spent = measured(lambda: result.rebalance(float(operation)))
    return {
        "vertices": len(v),
        "foldings at first": folded,
        "certified": bool(result.certificate),
        "microseconds a vertex": 1e6 * spent["cpu"] / len(v),
        "kB a vertex": 2**10 * spent["memory"] / len(v),
        "mean": np.abs(result.angle_differences()).mean(),
    }
