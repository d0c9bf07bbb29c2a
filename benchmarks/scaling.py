"""CPU time and memory a vertex as a mesh is refined.

    python -m benchmarks scaling OPERATION MESH [--levels 3] [--scipy]

OPERATION is "map" or a balance above 0, whose time is without that of the conformal map. MESH is a file or
"sample:SPEC". Each level runs in a process of its own, and is a line of JSON. With --scipy no other solver is found.
"""

from __future__ import annotations

import json
import sys

import numpy as np

import igl_spheremap as ism

from .common import in_process, load, measured, parser


def main(argv: list[str]) -> None:
    """Print the figures of all levels, or of one."""
    arguments = parser(__doc__)
    arguments.add_argument("operation")
    arguments.add_argument("source")
    arguments.add_argument("--levels", type=int, default=3, help="loop subdivisions (3)")
    arguments.add_argument("--only", type=int, help="measure this level in this process")
    arguments.add_argument("--scipy", action="store_true")
    options = arguments.parse_args(argv)
    if options.only is None:
        for level in range(options.levels + 1):
            print(json.dumps(in_process("scaling", *argv, "--only", level)), flush=True)
        return
    if options.scipy:
        sys.modules["cvxopt"] = sys.modules["sksparse"] = None  # type: ignore[assignment]
    print(json.dumps(figures(options.operation, *load(options.source, options.only)), default=float))


def figures(operation: str, v: np.ndarray, f: np.ndarray) -> dict[str, object]:
    """What is measured at one level."""
    result, spent = measured(lambda: ism.spherical_conformal_map(v, f))
    folded = result.rounds[0].foldings_after if result.rounds else 0
    if operation != "map":
        result, spent = measured(lambda: result.rebalance(float(operation)))
    size = np.abs(result.angle_differences())
    return {"vertices": len(v), "foldings at first": folded, "certified": bool(result.certificate),
            "microseconds a vertex": 1e6 * spent["cpu"] / len(v),
            "bytes a vertex": 2**20 * spent["memory"] / len(v), "backend": result.backend,
            "mean": size.mean(), "p99": np.percentile(size, 99), "timings": result.timings}
