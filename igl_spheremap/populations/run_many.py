"""Many jobs by one call: those whose results a manifest holds are not run again."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from datetime import datetime, timezone
from typing import Any

from ..gate import PathLike
from .engine import Engine, results, started
from .job import JobT, Task, host_and_process, key_of
from .manifest import Manifest
from .table import MAPPED, JobRow


def run_many(
    jobs: Sequence[JobT],
    task: Task[JobT],
    manifest: PathLike,
    engine: Engine,
    listener: Callable[[Any], None] | None = None,
) -> list[Any]:
    """Run a task on many inputs, and return their rows in order.

    Targets tell jobs apart. The rows are of the kind that the task makes.
    """
    rows: dict[str, JobRow] = {}
    todo: deque[JobT] = deque()

    def take(row: JobRow) -> None:
        rows[row.target] = row
        try:
            if listener is not None:
                listener(row)
        except StopIteration:
            todo.clear()

    began = datetime.now(timezone.utc).isoformat(timespec="seconds")
    run = {"options": repr(task), "began": began, "by": host_and_process()}
    with Manifest(manifest, run) as log, started(engine) as running:
        keys = {job: key_of(job, task, str(log.path.parent)) for job in jobs}
        kept = {}
        if engine.resume:
            kept = _earlier_rows(log, keys, made_only=any((engine.retry_failed, task.force)))
        todo.extend(
            replace(job, ours=log.made(keys[job], job.targets))
            for job in jobs
            if job.target not in kept
        )
        for row in kept.values():
            take(row)
        for job, result in results(running, todo, task):
            log.add(keys[job], result)
            take(result.row)
    return [rows[job.target] for job in jobs if job.target in rows]


def _earlier_rows(log: Manifest, keys: Mapping[JobT, str], made_only: bool) -> dict[str, JobRow]:
    """Rows of earlier runs for these jobs by target, in their order."""
    with ThreadPoolExecutor() as readers:  # of files whose times have changed
        known = list(readers.map(lambda job: log.result(keys[job], job.sources, job.targets), keys))
    return {
        job.target: replace(row, source=job.source, target=job.target, resumed=True)
        for job, row in zip(keys, known, strict=True)
        if row is not None and (row.status in MAPPED or not made_only)
    }
