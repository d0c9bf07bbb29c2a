"""One run of one competitor on one mesh, in a process of its own, so that its peak memory is its own.

Called by `peers.py` as ``python trial.py NAME MESH.npz CPU_SECONDS``; writes one line of JSON to stdout.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import resource
import sys
import time

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = os.environ["MKL_NUM_THREADS"] = "1"

import numpy as np
from competitors import COMPETITORS, FACTORS, factorised_matrix

import igl_spheremap as ism
from igl_spheremap.operators.factor.factorize import factorize


def main(name: str, path: str, cap: str) -> dict[str, object]:
    """Warm up on a small mesh, run once, and certify and measure the map afterwards."""
    resource.setrlimit(resource.RLIMIT_CPU, (int(cap), int(cap) + 60))
    with np.load(path) as data:
        v, f = data["v"], data["f"]
    small = ism.samples.make("spheroid", n_vertices=1500)
    if name in FACTORS:
        P = factorised_matrix(v, f)
        factorize(factorised_matrix(*small), FACTORS[name])
        return measured(lambda: factorize(P, FACTORS[name]))[1]
    COMPETITORS[name](*small)
    try:
        result, figures = measured(lambda: COMPETITORS[name](v, f))
    except (ValueError, RuntimeError, ArithmeticError) as error:
        return {"failure": f"{type(error).__name__}: {error}"[:160]}
    stages = {f"stage {stage}": seconds for stage, seconds in getattr(result, "timings", {}).items()}
    return figures | stages | quality(v, f, getattr(result, "sphere", result))


def measured(run):
    """What `run` returns, with its seconds and the growth of the process's peak memory in MB."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    wall, cpu = time.perf_counter(), time.process_time()
    result = run()
    figures = {"cpu": time.process_time() - cpu, "wall": time.perf_counter() - wall}
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return result, figures | {"memory": (peak - before) / 1024, "peak": peak / 1024}


def quality(v, f, x) -> dict[str, float]:
    """Exact foldings, and mean and 99th percentile of the angle differences in degrees."""
    if not np.isfinite(x).all():
        return {"failure": "positions that are not finite"}
    size = np.abs(ism.angle_differences(v, f, x))
    return {"foldings": ism.certify(x, f).foldings, "mean": float(size.mean()),
            "p99": float(np.percentile(size, 99))}


if __name__ == "__main__":
    with contextlib.redirect_stdout(io.StringIO()):
        figures = main(*sys.argv[1:])
    print(json.dumps(figures))
