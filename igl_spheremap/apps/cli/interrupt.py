"""Ctrl-C ends a run at its next iterate, with what there is."""

from __future__ import annotations

import signal
import threading
from types import FrameType
from typing import Any

from ...descent.iterate import Iterate


class Interrupt:
    """A listener that ends the run at the next iterate after Ctrl-C; a second Ctrl-C ends it at once.

    A context manager: the signal is caught inside.
    """

    def __init__(self) -> None:
        self.asked = False
        self._before: Any = None

    def __call__(self, iterate: Iterate) -> None:
        """End the run if Ctrl-C was pressed."""
        if self.asked:
            raise StopIteration

    def __enter__(self) -> Interrupt:
        if threading.current_thread() is threading.main_thread():  # elsewhere signals can't be caught
            self._before = signal.signal(signal.SIGINT, self._ask)
        return self

    def __exit__(self, *_: object) -> None:
        if self._before is not None:
            signal.signal(signal.SIGINT, self._before)

    def _ask(self, number: int, frame: FrameType | None) -> None:
        self.asked = True
        signal.signal(signal.SIGINT, signal.default_int_handler)
