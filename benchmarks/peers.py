"""Time, memory and quality of this package beside its peers, measured in one run.

``python benchmarks/peers.py`` takes the package's own samples; ``--meshes FILE ...`` takes yours. Each mesh is loop-
subdivided ``--levels`` times. Competitors take turns, each in a process of its own, with one thread and after a
warm-up; figures are medians over the rounds. Writes docs/benchmarks.md and docs/images/benchmarks.png.
"""

from __future__ import annotations

import argparse
import json
import signal
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import igl
import numpy as np
from competitors import COMPETITORS, FACTORS, LARGEST
from peers_report import plot, write_report

import igl_spheremap as ism

ROOT = Path(__file__).parents[1]
#: Rounds for meshes of up to so many vertices.
ROUNDS = ((300_000, 3), (10**9, 1))
#: A competitor that took longer than this, in seconds, is not repeated.
LONG = 20.0


def main(argv: list[str] | None = None) -> None:
    """Run the benchmark, and write the report after every mesh."""
    options = arguments().parse_args(argv)
    rows = json.loads(options.results.read_text()) if options.add else []
    with tempfile.TemporaryDirectory() as folder:
        for source in options.meshes:
            for mesh in subdivided(source, options.levels, Path(folder)):
                if options.smallest <= mesh["vertices"] <= options.largest:
                    rows.append(mesh | {"trials": compare(mesh, options)})
                    options.results.write_text(json.dumps(rows, indent=1))
                    write_report(rows, options.report)
                Path(mesh["path"]).unlink()
    plot(rows, options.image)


def arguments() -> argparse.ArgumentParser:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--meshes", nargs="+", default=["sample:brain", "sample:dino"],
                        help="files, or sample:NAME")
    parser.add_argument("--levels", type=int, default=3, help="loop subdivisions of each mesh (3)")
    parser.add_argument("--smallest", type=int, default=1_000, help="vertices below which a level is left out")
    parser.add_argument("--largest", type=int, default=700_000, help="vertices above which a level is left out")
    parser.add_argument("--only", nargs="+", default=[*COMPETITORS, *FACTORS], help="competitors")
    parser.add_argument("--cap", type=int, default=600, help="CPU seconds that a run may take (600)")
    parser.add_argument("--add", action="store_true", help="add to the results of earlier runs")
    parser.add_argument("--results", type=Path, default=ROOT / "benchmarks" / "peers.json")
    parser.add_argument("--report", type=Path, default=ROOT / "docs" / "benchmarks.md")
    parser.add_argument("--image", type=Path, default=ROOT / "docs" / "images" / "benchmarks.png")
    return parser


def subdivided(source: str, levels: int, folder: Path):
    """The mesh and its subdivisions, each in a file."""
    v, f = (ism.samples.make(source.removeprefix("sample:")) if source.startswith("sample:")
            else ism.read_mesh(source))
    for level in range(levels + 1):
        if level:
            v, f = igl.loop(v, f)
        path = folder / f"{Path(source).stem.replace(':', '_')}_{level}.npz"
        np.savez(path, v=v, f=f.astype(np.int64))
        yield {"name": source.removeprefix("sample:") if source.startswith("sample:") else Path(source).stem,
               "level": level, "vertices": len(v), "path": str(path)}


def compare(mesh: dict, options: argparse.Namespace) -> dict[str, dict]:
    """Figures of all competitors on one mesh: medians over rounds in which they take turns."""
    names = [name for name in options.only if mesh["vertices"] <= LARGEST.get(name, 10**9)]
    runs: dict[str, list[dict]] = {name: [] for name in names}
    for _ in range(next(rounds for most, rounds in ROUNDS if mesh["vertices"] <= most)):
        for name in names:
            done = runs[name]
            if done and ("failure" in done[-1] or done[-1]["wall"] > LONG):
                continue
            done.append(trial(name, mesh["path"], options.cap))
            print(mesh["name"], mesh["vertices"], name, done[-1], file=sys.stderr, flush=True)
    return {name: medians(done) for name, done in runs.items()}


def trial(name: str, path: str, cap: int) -> dict:
    """One run in a process of its own."""
    command = [sys.executable, str(Path(__file__).with_name("trial.py")), name, path, str(cap)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode == -signal.SIGXCPU:
        return {"failure": f"not done after {cap} s"}
    if done.returncode:
        return {"failure": (done.stderr.strip().splitlines() or [f"exit status {done.returncode}"])[-1][:160]}
    return json.loads(done.stdout)


def medians(runs: list[dict]) -> dict:
    """Median of each figure; the failure, if there was one."""
    failed = [run for run in runs if "failure" in run]
    return failed[0] if failed else {key: statistics.median(run[key] for run in runs) for key in runs[0]}


if __name__ == "__main__":
    main()
