"""Listeners for a terminal: how far a run is, a log of its iterates, and the way to stop it."""

from __future__ import annotations

import math
import signal
import threading
import time
from types import FrameType
from typing import Any, TextIO

import numpy as np
from numpy.typing import NDArray

from ...descent.iterate import Iterate
from ...verify.certificate import orientation_signs

_PATIENCE = 1.0  # seconds before the line appears
_SHARE = 10  # the line may cost this fraction of the time
_WIDTH = 79


class StatusLine:
    """A listener that redraws one line, if the stream is a terminal and the run takes over a second.

    Parameters
    ----------
    stream : text file
        Usually stderr.
    f : (m, 3) int64 array
        Faces, to count foldings.
    """

    def __init__(self, stream: TextIO, f: NDArray[np.int64]) -> None:
        self._stream, self._f = stream, f
        self._live = stream.isatty()
        self._next = time.monotonic() + _PATIENCE
        self._drawn = False

    def __call__(self, iterate: Iterate) -> None:
        """Draw the line, unless it was drawn a moment ago."""
        began = time.monotonic()
        if not self._live or began < self._next:
            return
        foldings = int((orientation_signs(iterate.x, self._f) <= 0).sum())
        line = f"{describe(iterate)}  foldings {foldings}"
        self._stream.write("\r" + line[:_WIDTH].ljust(_WIDTH))
        self._stream.flush()
        self._drawn = True
        now = time.monotonic()
        self._next = now + max(0.1, _SHARE * (now - began))

    def clear(self) -> None:
        """Leave the terminal as it was."""
        if self._drawn:
            self._stream.write("\r" + " " * _WIDTH + "\r")
            self._stream.flush()


class IterationLog:
    """A listener that prints one line per iterate.

    Parameters
    ----------
    stream : text file
        Usually stderr.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __call__(self, iterate: Iterate) -> None:
        """Print the iterate."""
        print(f"{describe(iterate)}  tau {iterate.tau:.2e}", file=self._stream, flush=True)


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


def describe(iterate: Iterate) -> str:
    """An iterate in a few words.

    Parameters
    ----------
    iterate : Iterate
        Any.

    Returns
    -------
    str
        Stage, round and iteration, energy beyond 4 pi, and residual.
    """
    gap = iterate.energy - 4 * math.pi
    words = f"{iterate.stage} {iterate.round}.{iterate.iteration}  energy 4 pi {gap:+.2e}"
    return words if math.isnan(iterate.residual) else f"{words}  residual {iterate.residual:.1e}"
