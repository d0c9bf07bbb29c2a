"""A population whose workers and whose client are killed: nothing may be lost, nothing done twice, no bit may differ.

    python -m benchmarks population [MESHES]

prints what happened. Samples of random shape are mapped by
`igl-spheremap batch`. After a fifth and two fifths of the meshes a worker is killed, after three fifths the client;
then `map_many` goes on. Its rows and files are compared with single maps in this process.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

import igl_spheremap as ism

COMMAND = [
    sys.executable,
    "-m",
    "igl_spheremap",
    "batch",
    "@meshes.txt",
    "--out",
    "spheres/{stem}.ply",
    "--jobs",
    "2",
]
MANIFEST = Path("spheres/maps.manifest.jsonl")
#: Of each sample: its share, a parameter that is random, and from where to where.
SHAPES = {
    "spheroid": (0.35, "aspect", 0.5, 3.0),
    "dumbbell": (0.3, "n_vertices", 300, 600),
    "pear": (0.3, "n_vertices", 300, 600),
    "dino": (0.03, "n_vertices", 1500, 1900),
    "spring": (0.02, "turns", 1.0, 3.0),
}

#: Share of the meshes that are the one before, scaled anew along each axis: a worker shares what depends on the faces.
MOVED = 0.3


def main(argv: list[str]) -> None:
    """Make the meshes, map them, and compare."""
    meshes = int(argv[0]) if argv else 2000
    os.chdir(tempfile.mkdtemp())
    make(meshes)
    began = time.perf_counter()
    print("killed workers", *interrupted(meshes))
    at_the_kill = rows_of_manifest()
    sources = Path("meshes.txt").read_text().split()
    rows = ism.map_many(sources, "spheres/{stem}.ply", engine=ism.Engine(processes=2))
    wall = time.perf_counter() - began
    written = rows_of_manifest()
    print(
        f"rows when the client was killed: {len(at_the_kill)}; taken over by the next run: "
        f"{sum(row.resumed for row in rows)}"
    )
    print(
        f"rows: {len(rows)} for {meshes} inputs; rows in the manifest: {len(written)}, with different keys: "
        f"{len({key for key, _ in written})}; statuses: {sorted({row.status for row in rows})}"
    )
    print(f"both runs: {wall:.1f} s, {meshes / wall:.1f} maps a second with 2 processes")
    compare(rows)


def make(meshes: int) -> None:
    """Samples whose shape, parameters and size are random, from one seed."""
    random = np.random.default_rng(0)
    os.mkdir("spheres")
    names = []
    for k in range(meshes):
        if k == 0 or random.random() > MOVED:
            shape = str(random.choice(list(SHAPES), p=[share for share, *_ in SHAPES.values()]))
            _, parameter, low, high = SHAPES[shape]
            value = random.uniform(low, high)
            size = int(value) if parameter == "n_vertices" else int(random.integers(300, 600))
            v, f = ism.samples.make(shape, **{parameter: value} | {"n_vertices": size})
        names.append(f"{k:04d}_{shape}.ply")
        ism.write_mesh(names[-1], v * random.uniform(0.5, 2, 3), f)
    Path("meshes.txt").write_text("\n".join(names))


def interrupted(meshes: int) -> list[str]:
    """Run until two workers and the client are killed; the workers."""
    killed: list[str] = []
    client = subprocess.Popen(COMMAND)
    for part in (1, 2, 3):
        while len(rows := rows_of_manifest()) < part * meshes // 5:
            time.sleep(0.05)
        if part == 3:
            client.kill()
            client.wait()
            return killed
        worker = next(worker for _, worker in reversed(rows) if worker not in killed)
        os.kill(int(worker.rpartition(":")[2]), 9)  # SIGKILL, a name that Windows lacks
        killed.append(worker)
    return killed


def rows_of_manifest() -> list[tuple[str, str]]:
    """Key and worker of each result."""
    if not MANIFEST.exists():
        return []
    lines = MANIFEST.read_text().split("\n")[:-1]  # the last one may be half a line
    return [
        (entry["key"], entry["row"]["worker"]) for entry in map(json.loads, lines) if "row" in entry
    ]


def compare(rows) -> None:
    """Compare files and rows with those of single maps, which share nothing."""
    spheres = figures = 0
    seconds = 0.0
    for row in rows:
        v, f = ism.read_mesh(row.source)
        result = ism.spherical_conformal_map(v, f, polish=None)  # the default of many files
        ism.write_map("alone.ply", result, force=True)
        spheres += Path("alone.ply").read_bytes() == Path(row.target).read_bytes()
        figures += replace(row, **columns(result)) == row
        seconds += row.seconds
    print(
        f"equal bit for bit with single maps: {spheres} files and {figures} rows of {len(rows)}, of which "
        f"{sum(shared(rows))} have the faces of the one before; the jobs took {seconds:.1f} s together"
    )


def columns(result) -> dict[str, float]:
    """The columns of a row that follow from its map."""
    sizes = {
        "angle": result.angle_differences(),
        "area": result.log_area_ratios(),
        "edge": ism.log_length_ratios(result.vertices, result.faces, result.sphere),
    }
    kinds = {"mean": np.mean, "p99": lambda size: np.percentile(size, 99), "max": np.max}
    measured = {
        f"{kind}_{name}": float(of(np.abs(values)))
        for name, values in sizes.items()
        for kind, of in kinds.items()
    }
    return measured | {
        "vertices": len(result.vertices),
        "energy": result.energy,
        "stretch": result.stretch,
        "foldings": result.certificate.foldings,
        "notes": "; ".join(result.notes),
    }


def shared(rows) -> list[bool]:
    """Whether each input has the faces of the one before it."""
    faces = [ism.read_mesh(row.source).f for row in rows]
    return [np.array_equal(f, g) for f, g in pairwise(faces)]
