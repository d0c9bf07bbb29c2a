"""Who does the work on a group's members: this process, or several others at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

from ..errors import FileError, MapError, MeshError
from ..mesh.timings import counted
from ..populations.child import ProcessPool, WorkerDied, own_child

T = TypeVar("T")


class Crew:
    """Processes that end with the context; one process is this one."""

    def __init__(self, processes: int) -> None:
        self._pool = ProcessPool(processes) if processes > 1 else None

    def __enter__(self) -> Crew:
        return self

    def __exit__(self, *_: object) -> None:
        if self._pool is not None:
            self._pool.end()

    def each(self, name: str, function: Callable[..., T], jobs: Sequence[tuple[Any, ...]]) -> Iterator[T | Exception]:
        """What a function returns for each job, in their order, or why one failed; progress has the name."""
        calls: list[Callable[[], T]]
        if self._pool is None:
            calls = [lambda job=job: function(*job) for job in jobs]  # type: ignore[misc]
        else:
            calls = [self._pool.submit(_in_child, function, job).result for job in jobs]
        for call in counted(name, calls):
            try:
                yield call()
            except (MeshError, FileError, MapError, WorkerDied) as error:
                yield error


def _in_child(function: Callable[..., T], job: tuple[Any, ...]) -> T:
    """The call in the process of this thread."""
    return own_child().call(function, *job)
