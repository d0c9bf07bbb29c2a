"""CPU seconds and memory of a factor and of a solve with three right-hand sides, by backend.

    python -m benchmarks factors MESH ... [--levels 0]

MESH is a file or "sample:SPEC", loop-subdivided this many times. Each factor is made in a process of its own, three
times in one, and the least time counts. Prints a table: factor / solve, memory in MB.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

import igl_spheremap as ism
from igl_spheremap.operators.factor.factorize import available_backends, factorize

from .common import in_process, load, measured, parser, timed
from .peers import factorised_matrix

_ROUNDS = 3


def main(argv: list[str]) -> None:
    """Print the table, or one cell as JSON."""
    arguments = parser(__doc__)
    arguments.add_argument("meshes", nargs="+")
    arguments.add_argument("--levels", type=int, default=0)
    arguments.add_argument("--backend", help="measure this one in this process")
    options = arguments.parse_args(argv)
    if options.backend:
        print(json.dumps(cell(*load(options.meshes[0], options.levels), options.backend)))
        return
    names = [Path(mesh).stem.removeprefix("sample:") for mesh in options.meshes]
    print("| backend | " + " | ".join(names) + " |\n|---" + "|---" * len(names) + "|")
    for backend in available_backends():
        found = [
            in_process("factors", mesh, "--levels", options.levels, "--backend", backend)
            for mesh in options.meshes
        ]
        cells = [
            one.get("failure") or "{factor:.3f} / {solve:.3f}, {memory:.0f}".format(**one)
            for one in found
        ]
        print(f"| {backend} | " + " | ".join(cells) + " |", flush=True)


def cell(v: np.ndarray, f: np.ndarray, backend: str) -> dict[str, float]:
    """Least seconds of a factor and a solve, and the growth of the peak while the first is made."""
    P = factorised_matrix(v, f)
    small = factorised_matrix(*ism.samples.make("spheroid", n_vertices=1500))
    factorize(small, backend).solve(np.ones((small.shape[0], 3)))
    b = np.random.default_rng(0).normal(size=(len(v), 3))
    factor, figures = measured(lambda: factorize(P, backend))
    factors, solves = [figures["cpu"]], []
    for _ in range(_ROUNDS):
        solves.append(timed(lambda: factor.solve(b))[1])  # noqa: B023
        factor, seconds = timed(lambda: factorize(P, backend))
        factors.append(seconds)
    return {"factor": min(factors), "solve": min(solves), "memory": figures["memory"]}
