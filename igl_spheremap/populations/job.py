"""Work on one input from files to files, and its row."""

from __future__ import annotations

import os
import socket
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from hashlib import sha256
from typing import Generic, TypeVar

from .._version import __version__
from ..errors import (
    FileError,
    FoldingsRemain,
    MeshError,
    Say,
    WorkersUnavailable,
    one_line,
    printable,
    said_by,
    said_here,
)
from ..io.files import part_of
from ..io.replacing import make_folder, remove_partial_files
from .child import WorkerDied, own_child, peak_memory
from .manifest import Fingerprints, JobResult, are_still, fingerprints
from .table import JobRow

_STATUS: dict[type[Exception], str] = {
    MeshError: "no mesh",
    FoldingsRemain: "folded",
    OSError: "file",
}


@dataclass(frozen=True)
class Job:
    """An input, and the first file made of it; if an earlier run made the files at the targets, `ours`."""

    source: str
    target: str
    ours: bool = field(default=False, compare=False, kw_only=True)

    @property
    def file(self) -> str:
        """The file of the source, which may be a part of it."""
        return str(part_of(self.source)[0])

    @property
    def sources(self) -> tuple[str, ...]:
        """All files that are read."""
        return (self.file,)

    @property
    def targets(self) -> tuple[str, ...]:
        """All files that are written."""
        return (self.target,)

    @property
    def chosen(self) -> tuple[object, ...]:
        """The part of the read files that is used, if not all: part of the result's key."""
        return tuple(part for part in part_of(self.source)[1:] if part is not None)


JobT = TypeVar("JobT", bound=Job)


@dataclass(frozen=True, kw_only=True)
class Task(ABC, Generic[JobT]):
    """The work on every input, and its version; relative paths begin in `folder`.

    Its `repr`, of all fields that decide the results, is part of their keys. Notes in rows say remedies by `say`, in
    any process.
    """

    force: bool = field(repr=False)
    folder: str = field(repr=False)
    version: str = __version__
    say: Say = field(default_factory=said_here, repr=False)

    def empty(self, job: JobT) -> JobRow:
        """The row of a job without results."""
        return JobRow(job.source, job.target)

    @abstractmethod
    def run(self, job: JobT, check: Callable[[], None]) -> JobRow:
        """Do the work from files to files.

        Call `check` once all is read: if a file changed meanwhile, it raises a FileError.
        """

    def place(self, path: str) -> str:
        """The place of a path on a machine with another working directory."""
        if os.getcwd() == self.folder:
            return path
        return os.path.join(self.folder, path)

    def places(self, paths: Sequence[str]) -> list[str]:
        """The places of several paths."""
        return [self.place(path) for path in paths]


def key_of(job: JobT, task: Task[JobT], folder: str) -> str:
    """The key of a result in a manifest in that folder, with which targets may move."""
    places = [os.path.relpath(os.path.realpath(target), folder) for target in job.targets]
    return sha256(
        " ".join([repr(task), repr(job.chosen), *places]).encode("utf-8", "surrogateescape")
    ).hexdigest()[:32]


def run_job(job: JobT, task: Task[JobT]) -> JobResult:
    """Run a job; its row has all faults of its files."""
    if task.version != __version__:
        raise WorkersUnavailable(
            f"{host_and_process()} has igl_spheremap {__version__} where {task.version} is "
            "asked for"
        )
    began = time.perf_counter()
    sources = task.places(job.sources)
    read = fingerprints(sources)
    kept: Fingerprints | None = read

    def check() -> None:
        if not are_still(sources, read):
            raise FileError(f"{' or '.join(job.sources)} changed while it was read; run it again")

    with said_by(task.say):
        try:
            for target in task.places(job.targets):
                make_folder(os.path.dirname(target))
            row = task.run(job, check)
        except Exception as error:  # one input must not end the others
            known = (status for kind, status in _STATUS.items() if isinstance(error, kind))
            row = replace(task.empty(job), status=next(known, "failed"), notes=one_line(error))
            if row.status == "file" or not are_still(sources, read):
                kept = None
    row = replace(
        row, seconds=time.perf_counter() - began, memory=peak_memory(), worker=host_and_process()
    )
    return JobResult(row, kept, fingerprints(task.places(job.targets)))


def run_in_child(job: JobT, task: Task[JobT], timeout: float | None) -> JobResult:
    """`run_job` in the process of this thread; a job that takes longer gets a row with the reason."""
    try:
        return own_child().call(run_job, job, task, timeout=timeout)
    except WorkerDied as died:
        for target in task.places(job.targets):
            remove_partial_files(target, died.pid)
        if not died.reason:
            raise
        return failed(job, task, died.reason)


def failed(job: JobT, task: Task[JobT], reason: str) -> JobResult:
    """The result of a job whose process ended before it did."""
    row = replace(task.empty(job), status="failed", notes=reason)
    return JobResult(
        row, fingerprints(task.places(job.sources)), fingerprints(task.places(job.targets))
    )


def host_and_process() -> str:
    """This process as `host:pid`."""
    return f"{socket.gethostname()}:{os.getpid()}"


def check_places(jobs: Sequence[Job], remedy: str) -> None:
    """Raise a ValueError if a file of a job would replace an input, or a file of another one."""
    owner = {
        os.path.realpath(path): f"{path}, which is an input" for job in jobs for path in job.sources
    }
    for job in jobs:
        for target in job.targets:
            if (place := os.path.realpath(target)) in owner:
                raise ValueError(
                    printable(f"out gives {job.source} the file {owner[place]}; {remedy}")
                )
            owner[place] = f"{target}, which is that of {job.source}, too"
