"""Jobs through workers: back pressure, and another try where a worker died."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait

from ..errors import WorkersUnavailable
from .executors import Workers
from .fingerprint import fingerprint
from .job import Job, Options, Result
from .table import Row

_AHEAD = 2  # jobs in flight for each worker: one that runs, and one that is there when it ends
_INTERVAL = 1.0  # seconds between two calls of `idle`


def results(
    workers: Workers, todo: deque[Job], options: Options, retries: int, idle: Callable[[], None]
) -> Iterator[tuple[Job, Result]]:
    """Results as they come, until `todo` is empty and nothing is in flight; `idle` is called about once a second."""
    running: dict[Future[Result], Job] = {}
    deaths: Counter[Job] = Counter()
    while todo or running:
        while todo and len(running) < _AHEAD * max(1, workers.count()):
            job = todo.popleft()
            running[_submit(workers, job, options)] = job
        for future in wait(running, _INTERVAL, FIRST_COMPLETED).done:
            job = running.pop(future)
            error = future.exception() if not future.cancelled() else CancelledError()
            if isinstance(error, CancelledError):
                raise WorkersUnavailable("the executor dropped its jobs, perhaps its scheduler is gone; run it again "
                                         "to continue")
            if not isinstance(error, workers.deaths):
                yield job, future.result()
                continue
            deaths[job] += 1
            if deaths[job] <= retries:
                todo.append(job)
            else:
                note = f"its worker died {deaths[job]} times: {error}" if retries else f"its worker died: {error}"
                yield job, (Row(job.source, job.target, status="failed", notes=note), fingerprint(job.target))
        idle()


def _submit(workers: Workers, job: Job, options: Options) -> Future[Result]:
    try:
        return workers.executor.submit(workers.call, job, options)
    except workers.deaths as error:  # a pool that broke takes no more jobs
        future: Future[Result] = Future()
        future.set_exception(error)
        return future
