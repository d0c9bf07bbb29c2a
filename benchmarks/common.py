"""Common code of benchmarks: meshes, clocks, figures of a map, and processes of their own."""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import igl
import numpy as np

import igl_spheremap as ism

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
IMAGES = DOCS / "images"


def parser(doc: str) -> argparse.ArgumentParser:
    """A command line whose help is a module's docstring."""
    return argparse.ArgumentParser(
        description=doc, formatter_class=argparse.RawDescriptionHelpFormatter
    )


def load(source: str, level: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """A file, or "sample:SPEC", loop-subdivided this many times."""
    sample = source.startswith("sample:")
    v, f = (
        ism.samples.from_spec(source.removeprefix("sample:")) if sample else ism.read_mesh(source)
    )
    for _ in range(level):
        v, f = igl.loop(v, f)
    return v, f


def fsaverage5() -> Path | None:
    """The folder of fsaverage5 in nilearn, if that is installed."""
    spec = importlib.util.find_spec("nilearn")
    return (
        Path(spec.submodule_search_locations[0], "datasets", "data", "fsaverage5") if spec else None
    )  # type: ignore


def timed(call: Callable[[], Any]) -> tuple[Any, float]:
    """A call's result, and its CPU seconds."""
    began = time.process_time()
    return call(), time.process_time() - began


def measured(call: Callable[[], Any]) -> tuple[Any, dict[str, float]]:
    """A call's result, with its CPU seconds, and the process's peak of memory and its growth, in MB."""
    before = peak_memory()
    result, cpu = timed(call)
    peak = peak_memory()
    return result, {"cpu": cpu, "memory": peak - before, "peak": peak}


def peak_memory() -> float:
    """Most memory that this process held, in MB; NaN on Windows, which has no such call."""
    try:
        import resource
    except ImportError:
        return float("nan")
    unit = 1 << 20 if sys.platform == "darwin" else 1 << 10  # bytes on macOS, kB elsewhere
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit


def quality(v: np.ndarray, f: np.ndarray, x: np.ndarray) -> dict[str, Any]:
    """Exact foldings, and mean and 99th percentile of the angle differences in degrees."""
    if not np.isfinite(x).all():
        return {"failure": "positions that are not finite"}
    size = np.abs(ism.angle_differences(v, f, x))
    return {
        "foldings": ism.certify(x, f).foldings,
        "mean": float(size.mean()),
        "p99": float(np.percentile(size, 99)),
    }


def in_process(*words: object, package: Path = ROOT, seconds: int | None = None) -> dict[str, Any]:
    """The JSON that a benchmark prints last, run in a process of its own: its peak of memory is its own.

    One that takes more CPU seconds than it may, or fails, returns its "failure".
    """
    command = [sys.executable, "-m", "benchmarks", "--package", str(package), *map(str, words)]
    try:
        done = subprocess.run(
            command, cwd=ROOT, capture_output=True, text=True, check=False, **time_limit(seconds)
        )
    except subprocess.TimeoutExpired:
        return {"failure": f"not done after {seconds} s"}
    if failure := fault(done, f"not done after {seconds} s"):
        return {"failure": failure}
    return json.loads(done.stdout.splitlines()[-1])


def fault(done: subprocess.CompletedProcess[str], late: str = "not done in time") -> str:
    """Why a process failed: that its time was over, or the last line that it wrote; nothing if it did not."""
    if done.returncode == -getattr(signal, "SIGXCPU", 0) < 0:
        return late
    lines = (done.stderr or "").strip().splitlines() or [f"exit status {done.returncode}"]
    return lines[-1][:160] if done.returncode else ""


def beside(command: list[object], seconds: int | None = None) -> None:
    """Run another program to its end; a RuntimeError if it fails."""
    done = subprocess.run(
        [*map(str, command)],
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
        timeout=seconds,
    )
    if failure := fault(done):
        raise RuntimeError(failure)


def time_limit(seconds: int | None) -> dict[str, Any]:
    """Arguments of `subprocess.run` by which a process ends after this many CPU seconds; on Windows, seconds."""
    if seconds is None:
        return {}
    return {"timeout": seconds} if os.name == "nt" else {"preexec_fn": lambda: limit_time(seconds)}


def limit_time(seconds: int) -> None:
    """End this process after this many further CPU seconds, or at its hard limit if that is less; not on Windows."""
    if os.name == "nt":
        return
    import resource

    most = int(time.process_time()) + seconds
    resource.setrlimit(resource.RLIMIT_CPU, (most, resource.getrlimit(resource.RLIMIT_CPU)[1]))


def octave(
    folder: str, code: str, seconds: int | None = None, **arrays: np.ndarray
) -> tuple[np.ndarray, float]:
    """Result of MATLAB code for arrays in Octave, and its CPU seconds; an environment variable names its folder."""
    if folder not in os.environ or shutil.which("octave-cli") is None:
        raise ImportError(
            f"Octave is not installed, or {folder} does not name the folder of its code"
        )
    from scipy.io import loadmat, savemat

    with tempfile.TemporaryDirectory() as place:
        source, target = Path(place) / "in.mat", Path(place) / "out.mat"
        savemat(source, arrays)
        script = (
            f"load('{source}'); began = cputime(); x = {code}; seconds = cputime() - began; "
            f"save('-v7', '{target}', 'x', 'seconds');"
        )
        beside(["octave-cli", "--path", os.environ[folder], "--eval", script], seconds)
        found = loadmat(target)
        return found["x"], float(found["seconds"].item())


def pyplot() -> Any:
    """matplotlib's plots, without a window."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot

    return matplotlib.pyplot
