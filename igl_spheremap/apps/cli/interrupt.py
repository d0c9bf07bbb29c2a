"""Ctrl-C and SIGTERM end a run at its next event, with what there is."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from types import FrameType
from typing import Any

from .exits import Exit

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Interrupt:
    """A listener that ends the run at the next event after a signal; a second one ends it at once.

    A context manager: signals are caught inside. `announce` is called at the first one.
    """

    def __init__(self, announce: Callable[[], None] = lambda: None) -> None:
        self.asked = 0  # the signal's number
        self._announce = announce
        self._before: dict[signal.Signals, Any] = {}

    def __call__(self, event: object) -> None:
        """End the run if a signal came."""
        if self.asked:
            raise StopIteration

    @property
    def status(self) -> Exit:
        """The exit status, as shells count it."""
        return Exit(128 + self.asked)

    def __enter__(self) -> Interrupt:
        if threading.current_thread() is threading.main_thread():  # elsewhere signals can't be caught
            self._before = {number: signal.signal(number, self._ask) for number in _SIGNALS}
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _ask(self, number: int, frame: FrameType | None) -> None:
        self.asked = number
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        self._announce()
