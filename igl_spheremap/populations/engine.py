"""Executors of jobs: our own processes, a Dask cluster, or any executor of the caller's; and limits of jobs."""

from __future__ import annotations

import asyncio
import json
import os
from collections import Counter, deque
from collections.abc import Callable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    wait,
)
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from .._version import __version__
from ..errors import WorkersUnavailable, check_number, check_whole, import_optional, one_line, shown
from ..gate import check_kinds
from .child import ProcessPool, WorkerDied, processors
from .job import Job, JobT, Task, failed, run_in_child, run_job
from .manifest import JobResult


@dataclass(frozen=True, kw_only=True)
class Engine:
    """The executor of jobs on many surfaces, their choice, and their limits.

    Attributes
    ----------
    executor : concurrent.futures.Executor, optional
        Executor of the jobs, such as that of a Dask client; by default processes of its own, with one thread each. It
        is not shut down.
    processes : int, optional
        Number of processes of its own; by default one for each processor.
    resume : bool
        If input, options and version are the same, and the target is unchanged, take a result from the manifest; the
        default.
    retry_failed : bool
        Run again the jobs that the manifest records without a result.
    timeout : float, optional
        Seconds after which a job is ended.
    retries : int
        Repeats of a job whose worker died; one by default.

    Raises
    ------
    TypeError, ValueError
        If one of these is of the wrong kind or out of range, or a timeout is given for an executor that can't keep it:
        one that is neither Dask's nor our own.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> ism.Engine(processes=4, timeout=600).retries
    1
    """

    _in_words = "an Engine"

    executor: Executor | None = None
    processes: int | None = None
    resume: bool = True
    retry_failed: bool = False
    timeout: float | None = None
    retries: int = 1

    def __post_init__(self) -> None:
        check_kinds(Engine, vars(self))
        if self.executor is not None and not callable(getattr(self.executor, "submit", None)):
            raise TypeError(
                f"executor is {shown(self.executor)}; give one of concurrent.futures, or of a Dask client"
            )
        if self.processes is not None:
            check_whole(self.processes, "processes", 1)
        check_whole(self.retries, "retries")
        if self.timeout is not None:
            check_number(self.timeout, "timeout")
            if not (
                self.executor is None
                or isinstance(self.executor, ProcessPool)
                or _is_dask(self.executor)
            ):
                raise ValueError(
                    "timeout limits jobs of the own pool and of Dask, not of other executors"
                )


#: Processes of its own, as many as processors.
USUAL = Engine()


@contextmanager
def started(engine: Engine) -> Iterator[Engine]:
    """An engine with an executor; if it has none, processes of its own, which end with the context."""
    if engine.executor is not None:
        yield engine
        return
    pool = ProcessPool(engine.processes)
    try:
        yield replace(engine, executor=pool)
    finally:
        pool.end()


def results(
    engine: Engine, todo: deque[JobT], task: Task[JobT]
) -> Iterator[tuple[JobT, JobResult]]:
    """Results of an engine that is started, as they come, until `todo` is empty and nothing is in flight.

    A job whose worker died is run again, up to `retries` times.
    """
    running: dict[Future[JobResult], JobT] = {}
    deaths, mortal = Counter[JobT](), deaths_in(engine.executor)
    while todo or running:
        # for each worker a job that runs, and one that waits to follow it
        while todo and len(running) < 2 * max(1, _count(engine.executor)):
            job = todo.popleft()
            running[_submit(engine, job, task)] = job
        for future in wait(running, return_when=FIRST_COMPLETED).done:
            job = running.pop(future)
            if future.cancelled() or isinstance(future.exception(), CancelledError):
                raise WorkersUnavailable(
                    "the executor dropped its jobs, perhaps its scheduler is gone; run it again "
                    "to continue"
                )
            if not isinstance(error := future.exception(), mortal):
                yield job, future.result()
                continue
            deaths[job] += 1
            if deaths[job] <= engine.retries:
                todo.append(job)
                continue
            times = ""
            if engine.retries:
                times = f" {deaths[job]} times"
            yield job, failed(job, task, f"its worker died{times}: {error}")


def deaths_in(executor: Executor | None) -> tuple[type[BaseException], ...]:
    """Exceptions of an executor for a job whose worker died."""
    if not _is_dask(executor):
        return BrokenExecutor, WorkerDied
    distributed = import_optional("distributed", "a Dask executor", "batch")
    return BrokenExecutor, WorkerDied, distributed.KilledWorker


def _is_dask(executor: Executor | None) -> bool:
    return type(executor).__module__.partition(".")[0] == "distributed"


def _count(executor: Executor | None) -> int:
    """Number of jobs at a time: on a cluster, whose workers come and go, the present one."""
    if _is_dask(executor):
        client: Any = vars(executor)["_client"]
        return sum(client.nthreads().values())
    return getattr(executor, "_max_workers", processors())


def _submit(engine: Engine, job: Job, task: Task[Any]) -> Future[JobResult]:
    assert engine.executor is not None
    run: Callable[..., JobResult] = run_job
    if isinstance(engine.executor, ProcessPool) or engine.timeout is not None:
        run = partial(run_in_child, timeout=engine.timeout)
    try:
        return engine.executor.submit(run, job, task)
    except BrokenExecutor as error:  # a pool that broke takes no more jobs
        future: Future[JobResult] = Future()
        future.set_exception(error)
        return future


def connect(scheduler: str, seconds: float = 6.0) -> Any:
    """An executor on the Dask scheduler at an address, or of a scheduler file.

    If it does not answer within some seconds, or a worker has another version, raise WorkersUnavailable.
    """
    distributed = import_optional("distributed", "a Dask scheduler", "batch")
    try:
        address = scheduler
        if os.path.isfile(scheduler):
            address = json.loads(Path(scheduler).read_bytes())["address"]
        # a client without a scheduler hangs when it is dropped
        asyncio.run(asyncio.wait_for(_greet(address), seconds))
    except Exception as error:  # anything may listen there
        reason = f"no valid answer within {seconds:g} s"
        if str(error) and isinstance(error, OSError | ValueError):
            reason = one_line(error)
        raise WorkersUnavailable(
            f"no Dask scheduler answers at {scheduler} ({reason}); start one by `dask scheduler`"
        ) from None
    client = distributed.Client(address, set_as_default=False, timeout=seconds)
    # An expression, since a worker of another version may lack the module of a function that is sent to it.
    versions = client.run(eval, "__import__('igl_spheremap').__version__", on_error="return")
    for worker, version in versions.items():
        if version != __version__:
            client.close()
            raise WorkersUnavailable(
                f"worker {worker} has igl_spheremap {version}, this is {__version__}; install "
                "the same version there"
            )
    return client.get_executor(pure=False)


async def _greet(address: str) -> None:
    """Ask the listener at an address; a ValueError unless it is a scheduler."""
    async with import_optional("distributed", "a Dask scheduler", "batch").rpc(address) as listener:
        kind = (await listener.identity())["type"]
    if kind != "Scheduler":
        raise ValueError(f"it is a {kind.lower()}")
