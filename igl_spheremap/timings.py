"""The time of a run: seconds by phase; the beginning of each and the progress of long loops are logged."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

LOGGER = logging.getLogger(__name__)
#: Message of `log_share`; the arguments of the record are name, number done, and total.
_COUNT = "%s: %d of %d"
T = TypeVar("T")
_SECONDS: ContextVar[dict[str, float] | None] = ContextVar("seconds", default=None)


@contextmanager
def timed() -> Iterator[None]:
    """Count the phases inside; `timings` gives their seconds."""
    token = _SECONDS.set({})
    try:
        yield
    finally:
        _SECONDS.reset(token)


def counted(name: str, items: Sequence[T]) -> Iterator[T]:
    """Yield the items of a long loop, and log the number done after each.

    >>> list(counted("steps", "ab"))
    ['a', 'b']
    """
    for done, item in enumerate(items):
        log_share(name, done, len(items))
        yield item
    log_share(name, len(items), len(items))


def log_share(name: str, done: int, total: int) -> None:
    """Log the progress of some work: 0 when it begins, all when it ends."""
    LOGGER.info(_COUNT, name, done, total)


def timings() -> dict[str, float]:
    """Wall seconds of the phases that ended so far in the run that counts them.

    >>> with timed():
    ...     with phase("outer"), phase("inner"):
    ...         pass
    ...     list(timings())
    ['inner', 'outer']
    """
    seconds = _SECONDS.get()
    if seconds is None:
        return {}
    return dict(seconds)


@contextmanager
def phase(name: str) -> Iterator[None]:
    """Add the time inside to the phase of that name; nested phases are subtracted."""
    LOGGER.info(name)
    outer = _SECONDS.get()
    if outer is None:
        yield
        return
    inner: dict[str, float] = {}
    token, began = _SECONDS.set(inner), time.perf_counter()
    try:
        yield
    finally:
        _SECONDS.reset(token)
        inner[name] = inner.get(name, 0.0) + time.perf_counter() - began - sum(inner.values())
        for key, seconds in inner.items():
            outer[key] = outer.get(key, 0.0) + seconds
