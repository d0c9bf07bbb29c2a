"""`igl-spheremap batch IN... --out PATTERN`: map many files with a pool of processes, and go on where it ended."""

from __future__ import annotations

import importlib
import importlib.util
import multiprocessing
import os
import signal
import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...descent.problem import harmonic_energy
from ...io import certify_radius, check_writable, format_of, read_sphere, write_map
from ...io.replacing import replacing
from ...maps.methods import METHODS
from ...maps.spherical_conformal_map import spherical_conformal_map
from ...verify.distortion import angle_differences
from .command import Command, UsageError
from .exits import Exit
from .failures import EXPECTED, told
from .outcomes import Outcome, summary, table
from .pair import check_fits
from .source import add_repair, load_source
from .streams import STREAM


def configure(parser: ArgumentParser) -> None:
    """Add the arguments of `batch`.

    Parameters
    ----------
    parser : ArgumentParser
        Gains them.

    Returns
    -------
    None
    """
    parser.add_argument("sources", metavar="IN", nargs="+", help="mesh files")
    parser.add_argument(
        "--out",
        metavar="PATTERN",
        required=True,
        help="where each sphere goes: {folder}, {name} and {stem} are those of IN, such as {folder}/lh.sphere "
        "or spheres/{stem}.ply",
    )
    parser.add_argument("--jobs", type=int, metavar="N", help="processes; default: one for each processor")
    parser.add_argument("--method", choices=tuple(METHODS), default="auto", help="default: auto")
    parser.add_argument("--summary", metavar="FILE", help="one line for each file: .csv or .jsonl")
    parser.add_argument("-f", "--force", action="store_true", help="map again what is there already")
    parser.add_argument("-q", "--quiet", action="store_true", help="print nothing")
    add_repair(parser)


def run(args: Namespace) -> Exit:
    """Map what is not mapped yet, certify what is, and tell.

    Parameters
    ----------
    args : Namespace
        As configured.

    Returns
    -------
    Exit
        The largest status of any file.
    """
    if args.jobs is not None and args.jobs < 1:
        raise UsageError(f"--jobs {args.jobs} is not positive")
    if STREAM in args.sources:
        raise UsageError("a batch reads files, not stdin")
    jobs = [Outcome(source, _target(args.out, source)) for source in args.sources]
    _check_targets(jobs)
    if args.summary is not None:
        if not args.summary.endswith((".csv", ".jsonl")):
            raise UsageError(f"--summary {args.summary}: give a .csv or .jsonl file")
        check_writable(args.summary, force=True)
    done, interrupted = _run_all(jobs, args)
    if args.summary is not None:
        with replacing(args.summary, force=True) as partial:
            partial.write_text(table(done, args.summary.endswith(".csv")))
    if not args.quiet:
        print(summary(done, len(jobs)), flush=True)
    return Exit.INTERRUPTED if interrupted else Exit(max(outcome.status for outcome in done))


def _target(pattern: str, source: str) -> str:
    path = Path(source)
    try:
        return pattern.format(folder=path.parent, name=path.name, stem=path.stem)
    except (KeyError, IndexError, ValueError):
        raise UsageError(f"--out {pattern}: known are {{folder}}, {{name}} and {{stem}}") from None


def _check_targets(jobs: Sequence[Outcome]) -> None:
    """Each file must have a place of its own, and its folder must be there."""
    owner: dict[str, str] = {}
    for job in jobs:
        format_of(job.target)
        check_writable(job.target, force=True)
        place = os.path.realpath(job.target)
        if place == os.path.realpath(job.source):
            raise UsageError(f"--out gives {job.source} its own name; the surface would be lost")
        if place in owner:
            raise UsageError(f"--out gives {job.target} to {owner[place]} and {job.source}; use {{folder}} or {{stem}}")
        owner[place] = job.source


def _run_all(jobs: Sequence[Outcome], args: Namespace) -> tuple[list[Outcome], bool]:
    """Outcomes in the order of the jobs, and whether Ctrl-C ended it early."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")  # the processes share the processors already
    options = (args.method, args.repair, args.keep_largest, args.force)
    interrupted = False
    # Ctrl-C reaches every process of a terminal: the pool's finish what they have begun.
    with ProcessPoolExecutor(
        args.jobs, multiprocessing.get_context("spawn"), signal.signal, (signal.SIGINT, signal.SIG_IGN)
    ) as pool:
        futures = [pool.submit(map_one, job, *options) for job in jobs]
        try:
            for _ in _with_bar(as_completed(futures), len(jobs), args.quiet):
                pass
        except KeyboardInterrupt:
            interrupted = True
            pool.shutdown(cancel_futures=True)
    pairs = zip(jobs, futures, strict=True)
    return [_outcome(job, future) for job, future in pairs if not future.cancelled()], interrupted


def _outcome(job: Outcome, future: Future[Outcome]) -> Outcome:
    try:
        return future.result()
    except BrokenProcessPool:
        return replace(job, status=Exit.FAILED, message="a process died, perhaps for want of memory; run it again")


def _with_bar(futures: Iterable[Any], total: int, quiet: bool) -> Iterator[Any]:
    """The same, with tqdm's bar on a terminal."""
    if quiet or not sys.stderr.isatty() or importlib.util.find_spec("tqdm") is None:
        return iter(futures)
    return iter(importlib.import_module("tqdm").tqdm(futures, total=total, unit="mesh", file=sys.stderr))


def map_one(job: Outcome, method: str, repair: bool, keep_largest: bool, force: bool) -> Outcome:
    """Map one file, or certify the sphere that it has; runs in a process of its own.

    Parameters
    ----------
    job : Outcome
        Source and target.
    method : str
        As for `spherical_conformal_map`.
    repair, keep_largest : bool
        Whether the mesh is mended at the door.
    force : bool
        Map again what is there already.

    Returns
    -------
    Outcome
        With a status and a message where anything expected failed.
    """
    try:
        source = load_source(Namespace(source=job.source, repair=repair, keep_largest=keep_largest))
        resumed = not force and Path(job.target).exists()
        if resumed:
            x, f = read_sphere(job.target)
            check_fits(source, job.target, x, f)
            check, seconds = certify_radius(x, source.f), 0.0
            x = x / np.linalg.norm(x, axis=1, keepdims=True)
        else:
            result = spherical_conformal_map(source.v, source.f, method)
            x, seconds = result.sphere, result.seconds
            check = write_map(job.target, result, force=force, metadata=source.metadata)
        angles = np.abs(angle_differences(source.v, source.f, x))
        return replace(
            job, status=Exit.OK if check.certificate.folding_free else Exit.FOLDINGS, resumed=resumed,
            vertices=len(x), foldings=check.certificate.foldings, energy=harmonic_energy(source.v, source.f, x),
            mean_angle=float(angles.mean()), max_angle=float(angles.max()), seconds=seconds,
        )  # fmt: skip
    except EXPECTED as error:
        status, line = told(error)
        return replace(job, status=status, message=line)


COMMAND = Command(
    "batch",
    "map many files with a pool of processes, and go on where it ended",
    """\
igl-spheremap batch subjects/*/surf/lh.white --out {folder}/lh.sphere --summary lh.csv
igl-spheremap batch meshes/*.ply --out spheres/{stem}.ply --jobs 4""",
    configure,
    run,
)
