"""CPU time and memory a vertex as a mesh is refined: python scaling.py OPERATION MESH [LEVELS]; prints JSON lines.

OPERATION is "map" or a balance above 0, whose time is without that of the conformal map. MESH is a file or
"sample:SPEC"; it is loop-subdivided LEVELS times (3). Each level runs in a process of its own, so that its peak of
memory is its own. With SCIPY_ALONE=1 in the environment no other solver is found.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

if os.environ.get("SCIPY_ALONE"):
    sys.modules["cvxopt"] = sys.modules["sksparse"] = None

import igl
import numpy as np
from trial import measured

import igl_spheremap as ism


def run(operation: str, source: str, level: int) -> dict[str, object]:
    """Figures of one level."""
    sample = source.startswith("sample:")
    v, f = ism.samples.from_spec(source[7:]) if sample else ism.read_mesh(source)
    for _ in range(level):
        v, f = igl.loop(v, f)
    result, figures = measured(lambda: ism.spherical_conformal_map(v, f))
    folded = result.rounds[0].foldings_after if result.rounds else 0
    if operation != "map":
        result, figures = measured(lambda: ism.rebalance(result, float(operation)))
    size = np.abs(result.angle_differences())
    row = {"vertices": len(v), "foldings at first": folded, "certified": bool(result.certificate),
           "microseconds a vertex": 1e6 * figures["cpu"] / len(v), "bytes a vertex": 2**20 * figures["memory"] / len(v)}
    row |= {"backend": result.backend, "mean": size.mean(), "p99": np.percentile(size, 99)}
    return row | {"timings": result.timings}


if __name__ == "__main__":
    operation, source, *rest = sys.argv[1:]
    if len(rest) < 2:
        for level in range(int(*rest or ["3"]) + 1):
            subprocess.run([sys.executable, __file__, operation, source, str(level), "alone"], check=True)
    else:
        print(json.dumps(run(operation, source, int(rest[0])), default=float))
