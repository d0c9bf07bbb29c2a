"""CPU time of a map by phase: by backend, or beside another version.

    python -m benchmarks phases [--backends cvxopt scipy] [--mesh sample:brain:n_vertices=240000] [--maps 3]
    python -m benchmarks phases CHECKOUT [--rounds 2] [--meshes 0 1 2 3]

CHECKOUT is a checkout of the other version. The two take turns, each in a process of its own with one thread, after a
warm-up; figures are the best of all rounds, in milliseconds. Prints tables.
"""

from __future__ import annotations

import functools
import json
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import igl_spheremap as ism
from igl_spheremap import timings

from .common import ROOT, in_process, load, parser

#: Loop subdivisions of the brain sample, and maps in a process; first a spheroid.
SIZES = ((None, 60), (0, 6), (1, 3), (2, 1))
#: Phases that ordering, CHOLMOD and its solves bound, and those outside.
LIMIT = ("order", "analysis", "factorisation", "solves")
OWN = (
    "check",
    "Laplacian",
    "triangle for CHOLMOD",
    "start",
    "steps",
    "gauge",
    "certificate",
    "repair",
)


def main(argv: list[str]) -> None:
    """Compare the two versions at all sizes."""
    arguments = parser(__doc__)
    arguments.add_argument("checkout", type=Path, nargs="?")
    arguments.add_argument("--backends", nargs="+", default=["cvxopt", "scipy"])
    arguments.add_argument("--mesh", default="sample:brain:n_vertices=240000")
    arguments.add_argument("--rounds", type=int, default=2, help="turns of each version (2)")
    arguments.add_argument(
        "--meshes", type=int, nargs="+", default=[0, 1, 2, 3], help="which of the meshes (0 1 2 3)"
    )
    arguments.add_argument(
        "--maps", type=int, help="only measure the mesh CHECKOUT, by this many maps, and print JSON"
    )
    options = arguments.parse_args(argv)
    if options.checkout is None:
        by_backend(*load(options.mesh), options.backends, options.maps or 3)
        return
    if options.maps:
        print(json.dumps(measure(options.checkout, options.maps)))
        return
    for subdivisions, maps in (SIZES[k] for k in options.meshes):
        runs: dict[Path, list[dict[str, float]]] = {options.checkout: [], ROOT: []}
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "mesh.npz"
            n = write(path, subdivisions)
            for _ in range(options.rounds):
                for version, done in runs.items():
                    done.append(in_process("phases", path, "--maps", maps, package=version))
        report(n, *(functools.reduce(best, done) for done in runs.values()))


def by_backend(v: np.ndarray, f: np.ndarray, backends: list[str], maps: int) -> None:
    """Print CPU seconds of each phase, the least of some maps."""
    timings.time.perf_counter = time.process_time  # type: ignore[attr-defined]
    found = []
    for backend in backends:
        ism.spherical_conformal_map(*ism.samples.make("sphere", n_vertices=1000), backend=backend)
        runs = [ism.spherical_conformal_map(v, f, backend=backend) for _ in range(maps)]
        found.append(functools.reduce(best, (run.timings | {"whole": run.seconds} for run in runs)))
    print(
        f"| {len(v):,} vertices | "
        + " | ".join(backends)
        + " |\n|---"
        + "|---:" * len(backends)
        + "|"
    )
    for phase in found[0]:
        print(f"| {phase} | " + " | ".join(f"{one[phase]:.3f}" for one in found) + " |")


def write(path: Path, subdivisions: int | None) -> int:
    """Write a mesh and return its number of vertices."""
    name = "spheroid:n_vertices=2562" if subdivisions is None else "brain:n_vertices=48000"
    v, f = load(f"sample:{name}", subdivisions or 0)
    np.savez(path, v=v, f=f)
    return len(v)


def measure(mesh: Path, maps: int) -> dict[str, float]:
    """CPU seconds of the phases that CHOLMOD bounds and of the whole, wall seconds of the others."""
    arrays = np.load(mesh)
    v, f = arrays["v"], arrays["f"]
    ism.spherical_conformal_map(v, f, backend="cvxopt")
    library = sys.modules["cvxopt.cholmod"]
    ours = (module for name, module in sys.modules.items() if name.startswith("igl_spheremap"))
    driver = next(
        module
        for module in ours
        if hasattr(module, "bandwidth_order") and hasattr(module, "Factor")
    )
    spent: dict[str, float] = defaultdict(float)
    for owner, name, phase in (
        (driver, "bandwidth_order", "order"),
        (driver, "nested_dissection", "order"),
        (library, "symbolic", "analysis"),
        (library, "numeric", "factorisation"),
        (driver.Factor, "solve", "solves"),
    ):
        if hasattr(owner, name):
            setattr(owner, name, clocked(getattr(owner, name), spent, phase))
    rounds = []
    for _ in range(maps):
        spent.clear()
        began = time.process_time()
        result = ism.spherical_conformal_map(v, f, backend="cvxopt")
        whole = time.process_time() - began
        own = dict(getattr(result, "timings", {}))
        own["triangle for CHOLMOD"] = own.pop("factorisation", 0.0) - sum(
            spent[phase] for phase in LIMIT[:3]
        )
        rounds.append(own | spent | {"outside": whole - sum(spent.values()), "whole": whole})
    return functools.reduce(best, rounds)


def clocked(
    function: Callable[..., Any], spent: dict[str, float], phase: str
) -> Callable[..., Any]:
    """The function, whose CPU time is added to that of a phase."""

    def call(*args: Any, **options: Any) -> Any:
        began = time.process_time()
        try:
            return function(*args, **options)
        finally:
            spent[phase] += time.process_time() - began

    return call


def best(a: dict[str, float], b: dict[str, float]) -> dict[str, float]:
    """The lesser time of each phase."""
    return {phase: min(a[phase], b[phase]) for phase in a}


def report(n: int, old: dict[str, float], new: dict[str, float]) -> None:
    """Print the table of a mesh in milliseconds."""
    print(f"\n| {n:,} vertices | before | now | ratio |\n|---|---:|---:|---:|")
    for phase in (*LIMIT, *OWN, "outside", "whole"):
        before, now = old.get(phase, 0.0), new[phase]
        ratio = f"{now / before:.2f}" if phase in (*LIMIT, "outside", "whole") else ""
        print(
            f"| {phase} | {f'{1e3 * before:.1f}' if ratio else ''} | {1e3 * now:.1f} | {ratio} |",
            flush=True,
        )
