"""`batch` and `summarise`: maps of many files, and which of them stand out."""

import os
import shlex
from argparse import Namespace
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ....errors import without_name
from ....io.replacing import check_writable
from ....populations.engine import Engine, connect
from ....populations.manifest import began
from ....populations.map_many import manifest_of, map_many, targets_of
from ....populations.mapping import SphereMapping
from ....populations.page import Sheet, check_page, map_sheet, write_page
from ....populations.ratings import FAIL, PASS, Rating, read_ratings
from ....populations.table import (
    MAPPED,
    OUTLIER,
    JobRow,
    Row,
    check_table,
    excess,
    figures_of,
    read_table,
    worst_first,
    write_table,
)
from ..arguments import chosen_method, repair_options
from ..exits import Exit, Interrupt, UsageError
from ..inputs import expand, subjects
from ..output import LISTED, aligned, check_apart, check_report, paragraph

_STATUS = {"certified": Exit.OK, "no mesh": Exit.NO_MESH, "folded": Exit.UNCERTIFIED, "failed": Exit.FAILED,
           "file": Exit.FILE}
_COSTS = {"seconds": "seconds", "memory": "memory in MB"}
_QUANTILES = (0, 25, 50, 75, 99, 100)


def run_batch(args: Namespace) -> Exit:
    """Map many files by processes or on a Dask cluster; run it again to continue.

    igl-spheremap batch meshes/*.ply --out spheres/{stem}.ply --jobs 4
    igl-spheremap batch --subjects-dir subjects --surface lh.white,rh.white --summary white.tsv
    igl-spheremap batch @files.txt --out {folder}/{stem}_sphere.ply --scheduler tcp://cluster:8786 --timeout 600
    """
    sources, method = list_sources(args), chosen_method(args, polish=None)  # all members are treated alike
    pattern = args.out or _beside(args)
    targets = _targets(pattern, sources)
    manifest = args.manifest or manifest_of(pattern)
    if args.manifest is None and args.subjects_dir is not None and not os.path.dirname(manifest):
        manifest = os.path.join(args.subjects_dir, manifest)  # so that a run from any folder continues it
    check_files(args, [*sources, *targets, manifest])
    repairs = repair_options(args)

    def run(**options: Any) -> list[Row]:
        return map_many(sources, pattern, method=method, balance=args.balance, repair=repairs or False,
                        force=args.force, manifest=manifest, **options)

    def sheet(rows: Sequence[Row]) -> Sheet:
        return map_sheet(rows, SphereMapping(method, args.balance, repairs, force=args.force, folder=os.getcwd()))

    return run_files(args, "mapping", len(sources), manifest, run, sheet)


def run_files(args: Namespace, name: str, total: int, manifest: str, run: Callable[..., list[Any]],
              sheet: Callable[[list[Any]], Sheet]) -> Exit:  # fmt: skip
    """Run a task on many files by the flags that all such commands have; print and write what came of it."""
    engine = engine_of(args)

    def announce() -> None:
        if not args.quiet:
            args.progress.write("igl-spheremap: finishing the meshes that were begun; Ctrl-C again ends at once")

    count = args.progress.count(name, total)
    with Interrupt(announce) as interrupt:

        def listen(row: JobRow) -> None:
            count(row.status == "certified", row.resumed)
            interrupt(row)

        rows = run(engine=engine, listener=listen)
    if args.summary is not None:  # before the page, whose pictures take longer and can be interrupted
        write_table(args.summary, rows)
    page = None
    if args.report is not None:
        args.progress.begin("drawing")
        page = write_page(args.report, rows, sheet(rows), args.jobs, began=began(manifest),
                          command=shlex.join(("igl-spheremap", *args.words)))
    args.progress.close()
    if not args.quiet:
        files = [paragraph(flag, str(path)) for flag, path in (("summary", args.summary), ("report", page)) if path]
        print(counts(rows, total), *files, sep="\n", flush=True)
    return interrupt.status if interrupt.asked else max(_STATUS[row.status] for row in rows)


def engine_of(args: Namespace) -> Engine:
    """Who runs the jobs, and when they end, by the flags of all commands for many files."""
    return Engine(executor=None if args.scheduler is None else connect(args.scheduler), processes=args.jobs,
                  resume=args.resume, retry_failed=args.retry_failed, timeout=args.timeout, retries=args.retries)


def list_sources(args: Namespace) -> list[str]:
    """The files of the command line or of a folder of subjects."""
    if bool(args.sources) == (args.subjects_dir is not None):
        raise UsageError("give mesh files, or --subjects-dir")
    sources = expand(args.sources) if args.sources else subjects(args.subjects_dir, args.surface)
    if not sources:
        raise UsageError(f"{' '.join(args.sources)} lists no file")
    return sources


def _beside(args: Namespace) -> str:
    """Choose the targets beside the sources, by names that FreeSurfer does not use; refuse files without --out."""
    if args.subjects_dir is None:
        raise UsageError("the following arguments are required: --out")
    return "{folder}/{name}" + (".balanced" if args.balance else ".conformal")


def _targets(pattern: str, sources: Sequence[str]) -> list[str]:
    try:
        return targets_of(pattern, sources)
    except ValueError as error:
        raise UsageError(f"--{error}") from None


def check_files(args: Namespace, others: Sequence[str]) -> None:
    """Raise an error before the work starts if --summary or --report can't be written, or would replace other files."""
    if args.summary is not None:
        try:
            check_table(args.summary)
        except ValueError as error:
            raise UsageError(f"--summary {error}") from None
        check_writable(args.summary, force=True)
        check_apart(args.summary, others, "--summary ")
    check_report(args)
    if args.report is not None:
        check_page(args.report)


def run_summarise(args: Namespace) -> None:
    """Print the quantiles and the outliers of many maps.

    igl-spheremap summarise white.tsv
    igl-spheremap summarise white.tsv --ratings ratings.tsv
    """
    rows = read_table(args.table)
    lines = [counts(rows, len(rows))]
    if args.ratings is not None:
        ratings = read_ratings(args.ratings, [row.source for row in rows])
        lines += _rated(ratings, len(rows))
        rows = [row for row in rows if row.source not in ratings or ratings[row.source].rating != FAIL]
    print(*lines, *_quantiles(rows), *_outliers(rows), sep="\n", flush=True)


def _rated(ratings: Mapping[str, Rating], total: int) -> list[str]:
    """How many passed and failed, and which failed, why."""
    failed = {source: rating for source, rating in ratings.items() if rating.rating == FAIL}
    lines = [paragraph("rated", f"{len(ratings) - len(failed)} {PASS}, {len(failed)} {FAIL}, which are left out below, "
                                f"{total - len(ratings)} not rated")]
    lines += [paragraph(FAIL, f"{source}: {rating.comment or 'no comment'}")
              for source, rating in list(failed.items())[:LISTED]]
    return lines + [paragraph("", f"and {len(failed) - LISTED} more")] * (len(failed) > LISTED)


def counts(rows: Sequence[JobRow], total: int) -> str:
    """Counts over the files that were given, and the first ones without a certified sphere."""
    bad = [row for row in rows if row.status != "certified"]
    resumed = sum(row.resumed for row in rows)
    there = f", {resumed} were there already" if resumed else ""
    lines = [paragraph("certified", f"{len(rows) - len(bad)} of {total} files{there}")]
    for row in bad[:LISTED]:
        reason = without_name(row.notes, row.source) or f"{row.foldings} foldings remain"
        lines.append(paragraph(row.status, f"{row.source}: {reason}"))
    if len(bad) > LISTED:
        lines.append(paragraph("", f"and {len(bad) - LISTED} more"))
    if len(rows) < total:
        lines.append(paragraph("interrupted", f"{total - len(rows)} files are left; run it again to continue"))
    return "\n".join(lines)


def _quantiles(rows: Sequence[JobRow]) -> list[str]:
    """A table of the figures of all maps."""
    cells = [("", *(f"{q}%" for q in _QUANTILES))]
    for name, label in (dict(figures_of(rows)) | _COSTS).items():
        values = np.array([getattr(row, name) for row in rows if row.status in MAPPED], dtype=np.float64)
        values = values[np.isfinite(values)]
        if len(values):
            cells.append((label, *(f"{value:.4g}" for value in np.percentile(values, _QUANTILES))))
    return ["", *aligned(cells, left=1)]


def _outliers(rows: Sequence[JobRow]) -> list[str]:
    """List the maps of which a figure lies far above those of the others."""
    beyond = excess(rows)
    found = [k for k in worst_first(rows) if beyond[k].max() > OUTLIER]
    lines = ["", paragraph("outliers", f"{len(found)} of {len(rows)} files: a figure more than {OUTLIER:g} "
                                       "interquartile ranges above the third quartile")]
    labels = list(figures_of(rows).items())
    for k in found[:LISTED]:
        name, label = labels[int(beyond[k].argmax())]
        lines.append(paragraph("", f"{rows[k].source}: {label} {getattr(rows[k], name):.4g}"))
    return lines
