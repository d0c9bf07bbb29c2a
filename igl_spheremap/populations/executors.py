"""Who runs the jobs: our own processes, a Dask cluster, or any executor of the caller's."""

from __future__ import annotations

import asyncio
import json
import os
from collections import Counter, deque
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from .._version import __version__
from ..errors import WorkersUnavailable, import_optional, one_line
from .child import ProcessPool, WorkerDied, check_memory_limit
from .job import Job, JobT, Task, failed, run_in_child, run_job
from .manifest import JobResult

_AHEAD = 2  # jobs in flight for each worker: one that runs, and one that waits to follow it
_INTERVAL = 1.0  # seconds between two calls of `idle`, which brings results to the disk
_ANSWER = 6.0  # seconds for a scheduler to answer: many round trips of a slow network, and a person still waits


@dataclass(frozen=True)
class Workers:
    """An executor, what it runs for a job, how many jobs it runs at a time, and how it reports a worker's death."""

    executor: Executor
    call: Callable[[Job, Task[Any]], JobResult]
    count: Callable[[], int]
    deaths: tuple[type[BaseException], ...] = (BrokenExecutor, WorkerDied)

    def results(
        self, todo: deque[JobT], task: Task[JobT], retries: int, idle: Callable[[], None]
    ) -> Iterator[tuple[JobT, JobResult]]:
        """Results as they come, until `todo` is empty and nothing is in flight; `idle` is called once a second.

        A job whose worker died is run again, up to `retries` times.
        """
        running: dict[Future[JobResult], JobT] = {}
        deaths: Counter[JobT] = Counter()
        while todo or running:
            while todo and len(running) < _AHEAD * max(1, self.count()):
                job = todo.popleft()
                running[self._submit(job, task)] = job
            for future in wait(running, _INTERVAL, FIRST_COMPLETED).done:
                job = running.pop(future)
                error = future.exception() if not future.cancelled() else CancelledError()
                if isinstance(error, CancelledError):
                    raise WorkersUnavailable("the executor dropped its jobs, perhaps its scheduler is gone; run it "
                                             "again to continue")
                if not isinstance(error, self.deaths):
                    yield job, future.result()
                    continue
                deaths[job] += 1
                if deaths[job] <= retries:
                    todo.append(job)
                else:
                    times = f" {deaths[job]} times" if retries else ""
                    yield job, failed(job, task, f"its worker died{times}: {error}")
            idle()

    def _submit(self, job: Job, task: Task[Any]) -> Future[JobResult]:
        try:
            return self.executor.submit(self.call, job, task)
        except self.deaths as error:  # a pool that broke takes no more jobs
            future: Future[JobResult] = Future()
            future.set_exception(error)
            return future


@contextmanager
def executor_of(executor: Executor | None, processes: int | None) -> Iterator[Executor]:
    """The caller's executor, or else a pool of our own processes that ends with the context."""
    if executor is not None:
        yield executor
        return
    pool = ProcessPool(processes or os.cpu_count() or 1)
    try:
        yield pool
    finally:
        pool.end()


@contextmanager
def workers_of(
    executor: Executor | None, processes: int | None, timeout: float | None, memory: float | None
) -> Iterator[Workers]:
    """The workers of an executor, or of `executor_of` without one."""
    limited = timeout is not None or memory is not None
    if memory is not None:
        check_memory_limit()
    in_child = partial(run_in_child, timeout=timeout, memory=memory)
    with executor_of(executor, processes) as found:
        if isinstance(found, ProcessPool):
            size = found.size
            yield Workers(found, in_child, lambda: size)
        elif type(found).__module__.partition(".")[0] == "distributed":
            killed = import_optional("distributed", "a Dask executor", "batch").KilledWorker
            client: Any = vars(found)["_client"]
            yield Workers(found, in_child if limited else run_job, lambda: sum(client.nthreads().values()),
                          (killed, WorkerDied))  # workers may come and go
        elif limited:
            raise ValueError("timeout and memory limit jobs of the own pool and of Dask, not of other executors")
        else:
            count = getattr(found, "_max_workers", os.cpu_count() or 1)
            yield Workers(found, run_job, lambda: count)


def connect(scheduler: str, seconds: float = _ANSWER) -> Any:
    """An executor on the Dask scheduler at an address, or of a scheduler file.

    Raise WorkersUnavailable if it does not answer within some seconds, or if a worker has another version.
    """
    distributed = import_optional("distributed", "a Dask scheduler", "batch")
    try:
        address = json.loads(Path(scheduler).read_bytes())["address"] if os.path.isfile(scheduler) else scheduler
        asyncio.run(asyncio.wait_for(_greet(address), seconds))  # a client without a scheduler hangs when it is dropped
    except Exception as error:  # what listens there may be anything
        known = str(error) and isinstance(error, OSError | ValueError)
        reason = one_line(error) if known else f"no valid answer within {seconds:g} s"
        raise WorkersUnavailable(f"no Dask scheduler answers at {scheduler} ({reason}); start one by "
                                 "`dask scheduler`") from None
    client = distributed.Client(address, set_as_default=False, timeout=seconds)
    # An expression, since a worker of another version may lack the module of a function that is sent to it.
    versions = client.run(eval, "__import__('igl_spheremap').__version__", on_error="return")
    for worker, version in versions.items():
        if version != __version__:
            client.close()
            raise WorkersUnavailable(f"worker {worker} has igl_spheremap {version}, this is {__version__}; install "
                                     "the same version there")
    return client.get_executor(pure=False)


async def _greet(address: str) -> None:
    """Ask who listens at an address; a ValueError unless it is a scheduler."""
    core = import_optional("distributed.core", "a Dask scheduler", "batch")
    comm = await core.connect(address)
    try:
        kind = (await core.send_recv(comm, op="identity"))["type"]
    finally:
        await comm.close()
    if kind != "Scheduler":
        raise ValueError(f"it is a {kind.lower()}")
