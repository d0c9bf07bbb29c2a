"""Maps a second of many small meshes: a plain loop, processes, and Dask workers; what a large study costs.

Run as ``python benchmarks/throughput.py [MESHES] [VERTICES]``; writes docs/throughput.md and its picture.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = os.environ["MKL_NUM_THREADS"] = "1"

import numpy as np

import igl_spheremap as ism
from igl_spheremap.draw.plot import new_figure
from igl_spheremap.populations.executors import connect
from igl_spheremap.populations.job import Job, Options, map_one

DOCS = Path(__file__).parent.parent / "docs"
_REPEATS = 3
CORTICES, CORTEX = 100_000, 160_000


def main(meshes: int = 120, vertices: int = 2562) -> None:
    """Measure, plot, and write the page."""
    os.chdir(tempfile.mkdtemp())
    sources = make(meshes, vertices)
    plain(sources[:2])  # the first maps of a process load its solvers
    rates: dict[str, dict[int, float]] = {"a plain loop": {1: best(lambda: meshes / plain(sources))}}
    start = min(first_row(sources[:1]) for _ in range(_REPEATS))
    for count in range(1, (os.cpu_count() or 1) + 1):
        rates.setdefault("processes", {})[count] = best(lambda count=count: many(sources, processes=count))
        with Cluster(count) as executor:
            rates.setdefault("Dask workers", {})[count] = best(lambda workers=executor: many(sources, executor=workers))
    draw(rates, vertices)
    write(rates, start, cortex(), moving(sources[:20]), moving(cortices()), meshes, vertices)


def make(meshes: int, vertices: int) -> list[str]:
    """Files of spheroids, no two of the same shape or with the same faces."""
    names = [f"{k}.ply" for k in range(meshes)]
    for k, name in enumerate(names):
        v, f = ism.samples.make("spheroid", n_vertices=vertices, aspect=1.2 + k / meshes)
        ism.write_mesh(name, *renumbered(v, f, k))
    return names


def renumbered(v, f, by: int):
    """The mesh with its vertices in another order."""
    return np.roll(v, by, axis=0), (f + by) % len(v)


def best(rate) -> float:
    """The largest of a few, since other programs may run, too."""
    return max(rate() for _ in range(_REPEATS))


def plain(sources) -> float:
    """Seconds to read, map and write, and nothing else."""
    began = time.perf_counter()
    for source in sources:
        ism.write_map("plain_" + source, ism.spherical_conformal_map(*ism.read_mesh(source)), force=True)
    return time.perf_counter() - began


def many(sources, **workers) -> float:
    """Maps a second of a population, from its first row on."""
    times: list[float] = []
    rows = ism.map_many(sources, "{stem}_sphere.ply", resume=False, listener=lambda row: times.append(
        time.perf_counter()), **workers)
    assert all(row.status == "certified" for row in rows)
    return (len(times) - 1) / (times[-1] - times[0])


def first_row(sources) -> float:
    """Seconds until a process has started and one mesh is mapped."""
    began = time.perf_counter()
    ism.map_many(sources, "{stem}_sphere.ply", resume=False, processes=1)
    return time.perf_counter() - began


class Cluster:
    """A Dask scheduler and workers of one thread each."""

    def __init__(self, workers: int) -> None:
        self.workers = workers

    def __enter__(self):
        command = [sys.executable, "-m", "distributed.cli.dask_{}", "--scheduler-file", "cluster.json",
                   "--no-dashboard"]
        extra = [["scheduler", "--port", "0"], *([["worker", "--nthreads", "1"]] * self.workers)]
        Path("cluster.json").unlink(missing_ok=True)
        self.processes = [subprocess.Popen([word.format(kind) for word in command] + options,
                                           stderr=subprocess.DEVNULL) for kind, *options in extra]
        while not Path("cluster.json").exists():
            time.sleep(0.1)
        self.executor = connect("cluster.json", 60)
        self.executor._client.wait_for_workers(self.workers)
        return self.executor

    def __exit__(self, *_) -> None:
        self.executor._client.close()
        for process in self.processes:
            process.terminate()
            process.wait()


def draw(rates, vertices: int) -> None:
    """Maps a second against workers."""
    figure, ((ax,),) = new_figure(1, 1, f"maps a second, {vertices:,} vertices", (4.5, 3.2))
    for name, points in rates.items():
        ax.plot(list(points), list(points.values()), marker="o", label=name)
    ax.set(xlabel="workers", ylim=(0, None), xticks=list(rates["processes"]))
    ax.legend()
    figure.savefig(DOCS / "images" / "throughput.png", dpi=110)


def moving(sources) -> float:
    """CPU time of maps that share their faces with the one before, over that of maps which do not."""
    options = Options(ism.Auto(), 0.0, False, False, True, os.getcwd())
    def spent(name: str) -> float:
        began = time.process_time()
        map_one(Job(name, "moving.ply", ""), options)
        return time.process_time() - began

    same, own = [], []
    for k, source in enumerate(sources):
        v, f = ism.read_mesh(source)
        ism.write_mesh("rolled.ply", *renumbered(v, f, k + 1), force=True)
        spent(source)
        same.append(spent(source))
        own.append(spent("rolled.ply"))
    return float(np.median(same) / np.median(own))


def cortices() -> list[str]:
    """Two cortices with the same faces."""
    v, f = ism.read_mesh("cortex.ply")
    ism.write_mesh("longer_cortex.ply", v * [1, 1, 1.1], f)
    return ["cortex.ply", "longer_cortex.ply"]


def cortex() -> float:
    """CPU seconds of one job with a cortex: read, map, write, measure."""
    ism.write_mesh("cortex.ply", *ism.samples.make("brain", n_vertices=CORTEX))
    options = Options(ism.Auto(), 0.0, False, False, True, os.getcwd())
    began = time.process_time()
    map_one(Job("cortex.ply", "cortex_sphere.ply", ""), options)
    return time.process_time() - began


def write(rates, start: float, cortex: float, same: float, same_cortex: float, meshes: int, vertices: int) -> None:
    """The page of the docs."""
    processes, workers = rates["processes"], max(rates["processes"])
    loop, one, many_ = rates["a plain loop"][1], processes[1], processes[workers]
    rows = "\n".join(f"| {name} | {count} | {rate:.1f} |" for name, points in rates.items()
                     for count, rate in points.items())
    efficiency = many_ / one / workers
    hours = CORTICES * cortex / efficiency / 3600
    disk = 500 * os.stat("cortex.ply").st_size / cortex / 1e6
    page = f"""# Throughput

Written by `python benchmarks/throughput.py`: {meshes} spheroids of {vertices:,} vertices, the size of a hippocampus, no
two alike, in PLY files; the best of {_REPEATS} runs. A plain loop reads, maps and writes; a population also measures
angles, areas and edges, keeps the manifest, and takes digests of inputs and results; it counts from its first row on.
One thread each. Machine: {os.cpu_count()} cores, {platform.system()} {platform.machine()}, Python
{platform.python_version()}, version {ism.__version__.removesuffix(".dev0")}.

| who | workers | maps a second |
|---|---:|---:|
{rows}

![Maps a second against workers](images/throughput.png)

- One process takes {100 * (loop / one - 1):.1f} percent longer for a mesh than the plain loop. It has started and
  mapped its first mesh after {start:.2f} s: over 1,000 meshes that makes
  {100 * ((1000 / one + start) / (1000 / loop) - 1):.1f} percent.
- {workers} processes map {many_ / one:.2f} times as much as one in the same time.
- Meshes that only move, in a worker that has just mapped the same faces, take {100 * same:.0f} percent of the CPU time
  of others, cortices of {CORTEX:,} vertices {100 * same_cortex:.0f} percent: the check of the faces, the order of
  elimination and its analysis are there already (`SphereMapper.move`).

## What a large study costs

A job costs its CPU seconds s, whoever runs it, and each of W workers costs its start s_0 once:

    core hours = (N s / e + W s_0) / 3600

where e is the efficiency of W workers, {efficiency:.2f} for {workers} here: the rate of all over W times that of one.
One cortex of {CORTEX:,} vertices, the sample `brain`, takes s = {cortex:.1f} s to read, map, write and measure. So
{CORTICES:,} of them take {hours:.0f} core hours: 500 workers are done in {hours / 500 * 60:.0f} minutes, if the disk
delivers {disk:.0f} MB a second.
"""
    (DOCS / "throughput.md").write_text(page)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
