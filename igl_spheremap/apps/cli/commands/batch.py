"""`batch`: maps of many files; and the way of all commands for many."""

import os
from argparse import Namespace
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ....errors import without_name
from ....io.replacing import check_writable, make_folder
from ....populations.engine import Engine, connect
from ....populations.job import Job, JobT, Task
from ....populations.map_many import manifest_of, targets_of
from ....populations.mapping import SphereMapping
from ....populations.page import Sheet, check_page, map_sheet, write_population_page
from ....populations.run_many import run_many
from ....populations.table import JobRow, check_table, write_table
from ..arguments import chosen_method, repair_of
from ..exits import Exit, Interrupt, UsageError, usage
from ..inputs import expand, parts_of
from ..output import LISTED, check_apart, check_report, command_of, paragraph

_STATUS = {
    "certified": Exit.OK,
    "no mesh": Exit.NO_MESH,
    "folded": Exit.UNCERTIFIED,
    "failed": Exit.FAILED,
    "file": Exit.FILE,
}


def run_batch(args: Namespace) -> Exit:
    # all members are treated alike
    sources, method = list_sources(args), chosen_method(args, polish=None)
    if args.parts:
        sources = [part for source in sources for part in parts_of(source)]
    with usage("--"):
        jobs = list(map(Job, sources, targets_of(args.out, sources)))
    task = SphereMapping(
        method, args.balance, repair_of(args), force=args.force, folder=os.getcwd()
    )
    return run_files(
        args, "mapping", jobs, task, manifest_of(args.out), lambda rows: map_sheet(rows, task)
    )


def run_files(args: Namespace, name: str, jobs: Sequence[JobT], task: Task[JobT], manifest: str,
              sheet: Callable[[list[Any]], Sheet]) -> Exit:  # fmt: skip
    """Run a task on many files by the flags that all such commands have; print and write the results."""
    if args.manifest is not None:
        manifest = args.manifest
    _check_files(args, [manifest, *(path for job in jobs for path in (*job.sources, *job.targets))])
    engine = engine_of(args)

    def announce() -> None:
        if not args.quiet:
            args.progress.write(
                "igl-spheremap: finishing the meshes that were begun; Ctrl-C again ends at once"
            )

    count = args.progress.count(name, len(jobs))
    with Interrupt(announce) as interrupt:

        def listen(row: JobRow) -> None:
            count(row.status == "certified", row.resumed)
            interrupt(row)

        rows = run_many(jobs, task, manifest, engine, listen)
    # before the page, whose pictures take longer and can be interrupted
    if args.summary is not None:
        write_table(args.summary, rows)
    page = None
    if args.report is not None:
        args.progress.begin("drawing")
        page = write_population_page(
            args.report,
            rows,
            sheet(rows),
            args.jobs,
            command=command_of(args),
        )
    args.progress.close()
    if not args.quiet:
        files = [
            paragraph(flag, str(path))
            for flag, path in (("summary", args.summary), ("report", page))
            if path
        ]
        print(counts(rows, len(jobs)), *files, sep="\n", flush=True)
    if interrupt.asked:
        return interrupt.status
    return max(_STATUS[row.status] for row in rows)


def engine_of(args: Namespace) -> Engine:
    """The executor and the limits of jobs, by the flags of all commands for many files."""
    executor = None
    if args.scheduler is not None:
        executor = connect(args.scheduler)
    return Engine(
        executor=executor,
        processes=args.jobs,
        resume=args.resume,
        retry_failed=args.retry_failed,
        timeout=args.timeout,
        retries=args.retries,
    )


def list_sources(args: Namespace) -> list[str]:
    """The files of the command line."""
    if not args.sources:
        raise UsageError("give mesh files")
    sources = expand(args.sources)
    if not sources:
        raise UsageError(f"{' '.join(args.sources)} lists no file")
    return sources


def _check_files(args: Namespace, others: Sequence[str]) -> None:
    """If --summary or --report can't be written, or would replace other files, raise an error before the work
    starts."""
    if args.summary is not None:
        with usage("--summary "):
            check_table(args.summary)
        make_folder(Path(args.summary).parent)
        check_writable(args.summary, force=True)
        check_apart(args.summary, others, "--summary ")
    check_report(args, "index.html")
    if args.report is not None:
        check_page(args.report)


def counts(rows: Sequence[JobRow], total: int) -> str:
    """Counts over the files that were given, and the first ones without a certified sphere."""
    bad = [row for row in rows if row.status != "certified"]
    resumed = sum(row.resumed for row in rows)
    certified = f"{len(rows) - len(bad)} of {total} files"
    if resumed:
        certified += f", {resumed} there already"
    lines = [paragraph("certified", certified)]
    for row in bad[:LISTED]:
        reason = f"{row.foldings} foldings remain"
        if row.notes:
            reason = without_name(row.notes, row.source)
        lines.append(paragraph(row.status, f"{row.source}: {reason}"))
    if len(bad) > LISTED:
        lines.append(paragraph("", f"and {len(bad) - LISTED} more"))
    if len(rows) < total:
        lines.append(
            paragraph(
                "interrupted",
                f"left: {total - len(rows)} of {total} files; run it again to continue",
            )
        )
    return "\n".join(lines)
