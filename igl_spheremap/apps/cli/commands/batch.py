"""`igl-spheremap batch IN... --out PATTERN`: map many files with a pool of processes; run again, it continues."""

from __future__ import annotations

import multiprocessing
import os
import re
import signal
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from concurrent.futures import CancelledError, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from ....descent.energies.harmonic import harmonic_energy
from ....errors import FileError
from ....io import certify_radius, check_writable, format_of, make_mark, read_mark, read_sphere, write_map
from ....io.replacing import replacing
from ....maps.balanced import balanced_spherical_map
from ....maps.options import METHODS
from ....verify.distortion import angle_differences
from ....verify.figures import log_figures
from ....verify.stretch import area_distortion
from ..exits import Exit
from ..failures import EXPECTED, UsageError, describe
from ..mapping import add_balance
from ..outcomes import Outcome, summary, table
from ..pair import check_fits
from ..source import add_repair, read_source
from ..streams import STREAM

_DIED = "the process that mapped it died, perhaps for lack of memory"
_FIELD = re.compile(r"\{(folder|name|stem)\}")


def configure(parser: ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("sources", metavar="IN", nargs="+", help="mesh files")
    parser.add_argument(
        "--out",
        metavar="PATTERN",
        required=True,
        help="where each sphere goes: {folder}, {name} and {stem} are those of IN, such as "
        "{folder}/lh.sphere.conformal or spheres/{stem}.ply",
    )
    parser.add_argument("--jobs", type=int, metavar="N", help="processes; default: one for each processor")
    parser.add_argument("--method", choices=tuple(METHODS), default="auto", help="default: auto")
    add_balance(parser)
    parser.add_argument("--summary", metavar="FILE", help="one line for each file: .csv or .jsonl")
    parser.add_argument(
        "-f", "--force", action="store_true", help="map again what is there already, and replace any other file"
    )
    parser.add_argument("-q", "--quiet", action="store_true", help="print nothing")
    add_repair(parser)


def run(args: Namespace) -> Exit:
    """Map what is not mapped yet, certify what is; the status is the largest of any file."""
    if args.jobs is not None and args.jobs < 1:
        raise UsageError(f"--jobs {args.jobs} is not positive")
    if STREAM in args.sources:
        raise UsageError("a batch reads files, not stdin")
    jobs = [Outcome(source, _target(args.out, source)) for source in args.sources]
    places = _check_targets(jobs)
    if args.summary is not None:
        if not args.summary.endswith((".csv", ".jsonl")):
            raise UsageError(f"--summary {args.summary}: give a .csv or .jsonl file")
        check_writable(args.summary, force=True)
        if os.path.realpath(args.summary) in places:
            raise UsageError(f"--summary {args.summary} is an input or another output, which would be lost")
    args.progress.stage("mapping", total=len(jobs), unit="mesh")
    done, interrupted = _run_all(jobs, args)
    args.progress.close()
    if args.summary is not None:
        with replacing(args.summary, force=True) as partial:
            partial.write_text(table(done, args.summary.endswith(".csv")), encoding="utf-8", errors="backslashreplace")
    if not args.quiet:
        print(summary(done, len(jobs)), flush=True)
    return Exit.INTERRUPTED if interrupted else Exit(max(outcome.status for outcome in done))


def _target(pattern: str, source: str) -> str:
    """The pattern with the parts of the source's path; it is no format string, whose fields can do anything."""
    path = Path(source)
    parts = {"folder": str(path.parent), "name": path.name, "stem": path.stem}
    if set("{}") & set(_FIELD.sub("", pattern)):
        raise UsageError(f"--out {pattern}: known are {{folder}}, {{name}} and {{stem}}")
    return _FIELD.sub(lambda field: parts[field[1]], pattern)


def _check_targets(jobs: Sequence[Outcome]) -> set[str]:
    """Raise an error unless each file has a target of its own that can be written; the places of all files."""
    owner = {os.path.realpath(job.source): f"{job.source}, which is an input" for job in jobs}
    for job in jobs:
        if not format_of(job.target).ordered:
            raise UsageError(f"--out gives {job.target}, whose format keeps no vertex order; give .ply, .obj or .npz")
        check_writable(job.target, force=True)
        place = os.path.realpath(job.target)
        if place in owner:
            raise UsageError(f"--out gives {job.source} the target {owner[place]}; use {{folder}} or {{stem}}")
        owner[place] = f"{job.target}, which is that of {job.source}, too"
    return set(owner)


def _run_all(jobs: Sequence[Outcome], args: Namespace) -> tuple[list[Outcome], bool]:
    """Outcomes in the order of the jobs, and whether Ctrl-C ended it early.

    Where a process dies, half as many continue with what is left; a mesh on which the last one dies is skipped.
    """
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")  # the processes share the processors already
    most = workers = args.jobs or os.cpu_count() or 1
    done: dict[str, Outcome] = {}
    left, interrupted = list(jobs), False
    while left and not interrupted:
        interrupted = _run_pool(left, workers, args, done)
        left = [job for job in jobs if job.target not in done]
        if workers > 1:
            workers //= 2
        elif left and not interrupted:
            deadly = left.pop(0)  # one process takes the meshes in their order
            done[deadly.target] = replace(deadly, status=Exit.FAILED, message=_DIED)
            workers = most
    return [done[job.target] for job in jobs if job.target in done], interrupted


def _run_pool(jobs: Sequence[Outcome], workers: int, args: Namespace, done: dict[str, Outcome]) -> bool:
    """Put outcomes into `done` until all are there or a process dies; True if Ctrl-C ended it early."""
    options = (args.method, args.repair, args.keep_largest, args.force, args.balance)
    with ProcessPoolExecutor(workers, multiprocessing.get_context("spawn")) as pool:
        # Ctrl-C reaches every process of a terminal; the pool's inherit that it is ignored, and finish their mesh.
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)
        futures = []
        with suppress(BrokenProcessPool):  # the first meshes may end it while the last are submitted
            for job in jobs:
                futures.append(pool.submit(map_one, job, *options))
        signal.signal(signal.SIGINT, before)
        interrupted = False
        try:
            for future in as_completed(futures):
                if future.exception() is None:
                    args.progress.advance()
        except KeyboardInterrupt:
            interrupted = True
            if not args.quiet:
                args.progress.write("igl-spheremap: finishing the meshes that were begun; Ctrl-C again ends at once")
            pool.shutdown(cancel_futures=True)
    for job, future in zip(jobs, futures, strict=False):
        with suppress(CancelledError, BrokenProcessPool):
            done[job.target] = future.result()
    return interrupted


def map_one(
    job: Outcome, method: str, repair: bool, keep_largest: bool, force: bool, balance: float = 0.0
) -> Outcome:
    """Map one file, or certify the map of it that an earlier run left; runs in a process of its own."""
    try:
        source = read_source(job.source, repair=repair, keep_largest=keep_largest)
        chosen = METHODS[method]()
        settings = chosen.settings() | ({"balance": balance} if balance else {})
        resumed = not force and Path(job.target).exists()
        if resumed:
            if read_mark(job.target) != make_mark(source.v, source.f, chosen.name, settings):
                raise FileError(f"{job.target} exists without the mark of this version, method and mesh; it is kept, "
                                "force=True replaces it")
            x, f = read_sphere(job.target)
            check_fits(source, job.target, x, f)
            check, seconds = certify_radius(x, source.f), 0.0
            x = x / np.linalg.norm(x, axis=1, keepdims=True)
        else:
            result = balanced_spherical_map(source.v, source.f, balance, method=chosen)
            x, seconds = result.sphere, result.seconds
            check = write_map(job.target, result, force=force, metadata=source.metadata)
        areas = log_figures(area_distortion(source.v, source.f, x))
        angles = np.abs(angle_differences(source.v, source.f, x))
        return replace(
            job, status=Exit.OK if check.certificate.folding_free else Exit.FOLDINGS, resumed=resumed,
            vertices=len(x), foldings=check.certificate.foldings, energy=harmonic_energy(source.v, source.f, x),
            mean_angle=float(angles.mean()), max_angle=float(angles.max()), mean_area=areas["mean"],
            seconds=seconds,
        )  # fmt: skip
    except EXPECTED as error:
        status, line = describe(error)
        return replace(job, status=status, message=line)
