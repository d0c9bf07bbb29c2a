"""Maps a second of many small meshes by a plain loop, processes and Dask workers, and the cost of a large study.

    python -m benchmarks throughput [--meshes 25] [--vertices 2562] [--rounds 6]

Writes docs/throughput.md, whose picture docs/pictures.py draws.
"""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

import numpy as np

import igl_spheremap as ism
from igl_spheremap.populations.child import Child
from igl_spheremap.populations.engine import connect
from igl_spheremap.populations.job import Job, run_job
from igl_spheremap.populations.mapping import SphereMapping

from .common import DOCS, parser

LOOP, POOL, DASK = "plain loops", "processes", "Dask workers"
CORTICES, CORTEX = 100_000, 160_000
PAIRS = 200
#: A plain loop: read, map, write. It prints when it began, when its imports and each mesh were done, and what each map
#: alone took.
PLAIN = """import json, sys, time
times, maps = [time.perf_counter()], []
import igl_spheremap as ism, igl_spheremap.populations.job
times.append(time.perf_counter())
for source in sys.argv[1:]:
    v, f = ism.read_mesh(source)
    began = time.perf_counter()
    result = ism.spherical_conformal_map(v, f, polish=None)
    maps.append(time.perf_counter() - began)
    ism.write_map("plain_" + source, result, force=True)
    times.append(time.perf_counter())
print(json.dumps([times, maps]))"""


def main(argv: list[str]) -> None:
    """Measure, plot, and write the page."""
    words = parser(__doc__)
    words.add_argument("--meshes", type=int, default=25)
    words.add_argument("--vertices", type=int, default=2562)
    words.add_argument("--rounds", type=int, default=6)
    asked = words.parse_args(argv)
    os.chdir(tempfile.mkdtemp())
    sources = make(asked.meshes, asked.vertices)
    seconds = cortex()
    share = {"small": moving(sources[:20]), "cortex": moving(cortices())}
    print("The rest takes about a minute and needs a quiet machine.", flush=True)
    pairs = in_turn(sources)
    rates, starts = measure(sources, asked.rounds)
    write(pairs, rates, starts, share, seconds, asked.meshes, asked.vertices)


def in_turn(sources):
    """Seconds of turns of a plain loop, and of jobs of a population in a process beside it, one after the other."""
    options, child = (
        SphereMapping(ism.Auto(polish=None), 0.0, None, force=True, folder=os.getcwd()),
        Child(),
    )
    turns, jobs = [], []
    for k in range(PAIRS):
        source = sources[k % len(sources)]
        began = time.perf_counter()
        ism.write_map(
            "plain_" + source, ism.spherical_conformal_map(*ism.read_mesh(source)), force=True
        )
        turns.append(time.perf_counter() - began)
        child.call(run_job, Job(source, "job_" + source), options)
        jobs.append(time.perf_counter() - began - turns[-1])
    child.end()
    return turns, jobs


def measure(sources, rounds: int):
    """Maps a second and starts in seconds, in rounds: what slows the machine for a while slows all that is compared."""
    rates: dict[tuple[str, int], list[float]] = {}
    starts: dict[str, list[float]] = {}
    counts = range(1, (os.cpu_count() or 1) + 1)
    with ExitStack() as stack:
        clusters = {count: stack.enter_context(Cluster(count)) for count in counts}
        for _ in range(rounds):
            for count in counts:
                rates.setdefault((LOOP, count), []).append(loops(sources, count, starts))
            for count in counts:
                rates.setdefault((POOL, count), []).append(many(sources, starts, processes=count))
            for count in counts:
                rates.setdefault((DASK, count), []).append(
                    many(sources, {}, executor=clusters[count])
                )
    return rates, {name: min(seconds) for name, seconds in starts.items()}


def loops(sources, count: int, starts) -> float:
    """Maps a second of plain loops side by side, each from its first mesh on."""
    command = [sys.executable, "-c", PLAIN, *sources]
    processes = [subprocess.Popen(command, stdout=subprocess.PIPE) for _ in range(count)]
    rate = 0.0
    for process in processes:
        times, maps = json.loads(process.communicate()[0])
        rate += (len(sources) - 1) / (times[-1] - times[2])
        for name, seconds in (
            ("import", times[1] - times[0]),
            ("first", maps[0]),
            ("next", maps[1]),
        ):
            starts.setdefault(name, []).append(seconds)
    return rate


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


def many(sources, starts, **workers) -> float:
    """Maps a second of a population, from its first row on; until then is its start."""
    times = [time.perf_counter()]
    rows = ism.map_many(
        sources,
        "{stem}_sphere.ply",
        listener=lambda row: times.append(time.perf_counter()),
        engine=ism.Engine(resume=False, **workers),
    )
    assert all(row.status == "certified" for row in rows)
    starts.setdefault("row", []).append(times[1] - times[0])
    return (len(times) - 2) / (times[-1] - times[1])


class Cluster:
    """A Dask scheduler and workers of one thread each."""

    def __init__(self, workers: int) -> None:
        self.workers = workers

    def __enter__(self):
        name = f"cluster{self.workers}.json"
        command = [
            sys.executable,
            "-m",
            "distributed.cli.dask_{}",
            "--scheduler-file",
            name,
            "--no-dashboard",
        ]
        extra = [["scheduler", "--port", "0"], *([["worker", "--nthreads", "1"]] * self.workers)]
        self.processes = [
            subprocess.Popen(
                [word.format(kind) for word in command] + options, stderr=subprocess.DEVNULL
            )
            for kind, *options in extra
        ]
        while not Path(name).exists():
            time.sleep(0.1)
        self.executor = connect(name, 60)
        self.executor._client.wait_for_workers(self.workers)
        return self.executor

    def __exit__(self, *_) -> None:
        self.executor._client.close()
        for process in self.processes:
            process.terminate()
            process.wait()


def moving(sources) -> float:
    """CPU time of maps that share their faces with the one before, over that of maps which do not."""
    options = SphereMapping(ism.Auto(polish=None), 0.0, None, force=True, folder=os.getcwd())

    def spent(name: str) -> float:
        began = time.process_time()
        run_job(Job(name, "moving.ply"), options)
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
    options = SphereMapping(ism.Auto(polish=None), 0.0, None, force=True, folder=os.getcwd())
    began = time.process_time()
    run_job(Job("cortex.ply", "cortex_sphere.ply"), options)
    return time.process_time() - began


def write(pairs, rates, starts, share, cortex: float, meshes: int, vertices: int) -> None:
    """The page of the docs."""
    workers = max(count for _, count in rates)
    rows = "\n".join(
        f"| {name} | {count} | {max(values):.1f} | {np.median(values):.1f} |"
        for (name, count), values in rates.items()
    )
    alone, beside = (
        float(np.median(np.divide(rates[name, workers], rates[name, 1]))) for name in (LOOP, POOL)
    )
    quarter, half = (100 * (job / turn - 1) for turn, job in np.percentile(pairs, [25, 50], axis=1))
    start = starts["row"] * max(rates[LOOP, 1]) / 1000
    efficiency = beside / workers
    hours = CORTICES * cortex / efficiency / 3600
    disk = 500 * os.stat("cortex.ply").st_size / cortex / 1e6
    version = ism.__version__.removesuffix(".dev0")
    page = f"""# Throughput

Written by `python -m benchmarks throughput` with version {version}: {meshes} spheroids of {vertices:,} vertices,
the size of a hippocampus, no two of the same shape or with the same faces, in PLY files. A plain loop reads,
maps and writes; a population also measures angles, areas and edges, keeps the manifest, and takes digests of inputs
and results. Times are wall times, measured in turn; ratios are medians. One thread each.
Machine: {os.cpu_count()} cores, {platform.system()} {platform.machine()}, Python
{platform.python_version()}.

| who | how many | maps a second, best of {len(rates[LOOP, 1])} | median |
|---|---:|---:|---:|
{rows}

![Maps a second against workers](images/throughput.png)

- **Against the loop**: a job of a population takes {quarter:.1f} percent longer than a turn of the plain loop by the
  lower quartiles of {PAIRS} each, run in turn in two processes, and {half:.1f} percent by their medians.
- **Start**: a process has started and mapped its first mesh after {starts["row"]:.2f} s, once for a worker;
  over 1,000 meshes that is {100 * start:.1f} percent.
- **First map**: a plain loop imports the package in {starts["import"]:.2f} s. Its first map takes
  {1000 * starts["first"]:.0f} ms, with the imports that only a map needs, the next one {1000 * starts["next"]:.0f} ms.
- **More processes**: {workers} processes map {beside:.2f} times as much as one in the same time; {workers} plain loops
  side by side, which share nothing, {alone:.2f} times as much as one.
- **Same connectivity**: meshes that only move, in a worker that has just mapped the same faces, take
  {100 * share["small"]:.0f} percent of the CPU time of others, cortices of {CORTEX:,} vertices
  {100 * share["cortex"]:.0f} percent (`SphereMapper.move`).

## Cost of a large study

A job costs its CPU seconds s on any worker, and each of W workers costs its start s_0 once:

    core hours = (N s / e + W s_0) / 3600

where e is the efficiency of W workers, {efficiency:.2f} for {workers} here: the rate of all over W times that of one.
One cortex of {CORTEX:,} vertices, the sample `brain`, takes s = {cortex:.1f} s to read, map, write and measure. So
{CORTICES:,} of them take {hours:.0f} core hours: 500 workers are done in {hours / 500 * 60:.0f} minutes, if the disk
delivers {disk:.0f} MB a second.
"""
    (DOCS / "throughput.md").write_text(page)
