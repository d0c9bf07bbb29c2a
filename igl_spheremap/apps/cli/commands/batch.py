"""Map many files by processes or on a Dask cluster; run it again to continue.

    igl-spheremap batch meshes/*.ply --out spheres/{stem}.ply --jobs 4
    igl-spheremap batch --subjects-dir subjects --surface lh.white,rh.white --summary white.tsv
    igl-spheremap batch @files.txt --out {folder}/{stem}_sphere.ply --scheduler tcp://cluster:8786 --timeout 600
"""

from __future__ import annotations

import os
from argparse import Namespace
from collections.abc import Sequence

from ....io import check_writable
from ....populations.executors import connect
from ....populations.map_many import map_many
from ....populations.table import Row, check_table, write_table
from ....populations.targets import manifest_of, targets_of
from ..chosen import chosen_method
from ..exits import Exit
from ..failures import UsageError
from ..inputs import expand, subjects
from ..interrupt import Interrupt
from .summarise import STATUS, counts, with_flags_in_notes


def run(args: Namespace) -> Exit:
    """Map what is not mapped yet; the status is the largest of any file."""
    sources, method = _sources(args), chosen_method(args)
    pattern = args.out or _beside(args)
    targets = _targets(pattern, sources)
    _check_summary(args.summary, [*sources, *targets, args.manifest or manifest_of(pattern)])
    executor = connect(args.scheduler) if args.scheduler is not None else None
    args.progress.stage("mapping", total=len(sources), unit="mesh")

    def announce() -> None:
        if not args.quiet:
            args.progress.write("igl-spheremap: finishing the meshes that were begun; Ctrl-C again ends at once")

    with Interrupt(announce) as interrupt:

        def listen(row: Row) -> None:
            args.progress.advance()
            interrupt(row)

        rows = map_many(
            sources, pattern, executor=executor, processes=args.jobs, method=method,
            balance=args.balance, repair=args.repair, keep_largest=args.keep_largest, force=args.force,
            manifest=args.manifest, resume=args.resume, retry_failed=args.retry_failed, timeout=args.timeout,
            memory=args.memory, retries=args.retries, report=args.report, listener=listen,
        )  # fmt: skip
    rows = with_flags_in_notes(rows)
    args.progress.close()
    if args.summary is not None:
        write_table(args.summary, rows)
    if not args.quiet:
        print(counts(rows, len(sources)), flush=True)
    return interrupt.status if interrupt.asked else max(STATUS[row.status] for row in rows)


def _sources(args: Namespace) -> list[str]:
    if args.keep_largest and not args.repair:
        raise UsageError("--keep-largest goes with --repair")
    if bool(args.sources) == (args.subjects_dir is not None):
        raise UsageError("give mesh files, or --subjects-dir")
    sources = expand(args.sources) if args.sources else subjects(args.subjects_dir, args.surface)
    if not sources:
        raise UsageError(f"{' '.join(args.sources)} lists no file")
    return sources


def _beside(args: Namespace) -> str:
    """The default pattern, whose names FreeSurfer does not use."""
    if args.subjects_dir is None:
        raise UsageError("the following arguments are required: --out")
    return "{folder}/{name}" + (".balanced" if args.balance else ".conformal")


def _targets(pattern: str, sources: Sequence[str]) -> list[str]:
    try:
        return targets_of(pattern, sources)
    except ValueError as error:
        raise UsageError(f"--{error}") from None


def _check_summary(path: str | None, others: Sequence[str]) -> None:
    if path is None:
        return
    try:
        check_table(path)
    except ValueError as error:
        raise UsageError(f"--summary {error}") from None
    check_writable(path, force=True)
    if os.path.realpath(path) in set(map(os.path.realpath, others)):
        raise UsageError(f"--summary {path} is an input or another output, which would be lost")
