"""The present work of a command: one line on a terminal, drawn by tqdm, and a line a minute in logs."""

import logging
import math
import sys
import time
from collections.abc import Callable
from itertools import count

from tqdm import tqdm

from ...mesh.arrays import IntArray
from ...result.run import Iterate, Listener, title_of
from ...timings import LOGGER
from ...verify.signs import folded_faces

#: Descriptions of phases of the library that take long on large meshes.
_LONG = {"factorisation": "factorising", "repair": "finishing the map", "certificate": "certifying"}


class _Line(tqdm):
    """A line of tqdm that ends where the terminal does: without a bar it would be wrapped."""

    def __str__(self) -> str:
        text, columns = super().__str__(), self.format_dict["ncols"]
        if columns is None:
            return text
        return text[: max(columns - 1, 1)]


class Progress(logging.Handler):
    """A context that shows the present work: on a terminal a line that is cleared, in a log a line a minute.

    Activities are those of the command. Logs of the library are shown beside the name and the time of one, and the
    progress of a loop as a share, with the time that is left.
    """

    def __init__(self, quiet: bool = False) -> None:
        super().__init__(logging.INFO)
        self._terminal = sys.stderr.isatty() and not quiet
        # seconds between lines of a log, and of a terminal, where foldings are counted anew for each
        self._interval, self._shown = 60.0, time.monotonic()
        if self._terminal:
            self._interval, self._shown = 0.5, -math.inf
        elif quiet:
            self._interval = math.inf
        self._bar: _Line | None = None
        self._activity = ""
        self._loop: object = None  # the outermost one that is counted
        self._share = ""  # its share that is done, and the time that is left
        self._began = 0.0

    def __enter__(self) -> "Progress":
        LOGGER.addHandler(self)
        LOGGER.setLevel(logging.INFO)
        return self

    def __exit__(self, *_: object) -> None:
        LOGGER.removeHandler(self)
        LOGGER.setLevel(logging.NOTSET)
        self.close()

    def emit(self, record: logging.LogRecord) -> None:
        """Show a phase of the library, or the progress of one of its loops."""
        if isinstance(record.args, tuple) and len(record.args) == 3:
            name, done, total = record.args
            self._count_loop(name, int(str(done)), int(str(total)))
        elif record.msg in _LONG and self._loop is None and (self._terminal or self._due()):
            self._line(": ".join(filter(None, (self._activity, _LONG[record.msg]))))

    def begin(self, name: str) -> None:
        """Begin an activity."""
        self.close()
        self._activity = name
        if self._terminal:
            self._bar = _Line(
                desc=name,
                bar_format="{desc} [{elapsed}{postfix}]",
                leave=False,
                dynamic_ncols=True,
                file=sys.stderr,
            )
        elif self._due():
            self._line(name)

    def steps(self, name: str, total: int) -> Callable[[], object]:
        """Begin an activity of this many steps; call the result for each."""
        self.begin(name)
        done = count()
        self._count_loop(name, next(done), total)
        return lambda: self._count_loop(name, next(done), total)

    def count(self, name: str, total: int) -> Callable[[bool, bool], None]:
        """Begin to go through files; call the result for each: is its map certified, was it made before?"""
        self.begin(name)
        began = time.monotonic()
        done = failed = new = 0

        def take(certified: bool, made_before: bool) -> None:
            nonlocal done, failed, new
            done, failed, new = done + 1, failed + (not certified), new + (not made_before)
            if new and done < total and (self._terminal or self._due()):
                rate = new / max(time.monotonic() - began, 1e-3)
                self._line(
                    f"{name}: {done} of {total} files done, {failed} failed; {60 * rate:.3g} a minute, "
                    f"{_duration((total - done) / rate)} left"
                )

        return take

    def listener(self, f: IntArray) -> Listener:
        """A listener that shows iterates of a map with faces `f`: energy, residual and foldings."""

        def show(iterate: Iterate) -> None:
            if self._due():
                foldings = int(folded_faces(iterate.x, f).sum())
                self._line(
                    f"{title_of(iterate)}{self._share}", f"foldings {foldings}, {measures(iterate)}"
                )

        return show

    def write(self, line: str) -> None:
        """Print a line on stderr that stays."""
        if self._bar is None:  # tqdm's lock may be missing where a signal came in its midst
            print(line, file=sys.stderr, flush=True)
        else:
            tqdm.write(line, file=sys.stderr)
            sys.stderr.flush()

    def close(self) -> None:
        """Clear the line."""
        if self._bar is not None:
            self._bar.close()
        self._bar, self._activity, self._loop, self._share = None, "", None, ""

    def _due(self) -> bool:
        """Whether it is time for another line, which is shown now."""
        now = time.monotonic()
        if due := now - self._shown >= self._interval:
            self._shown = now
        return due

    def _line(self, text: str, postfix: str = "") -> None:
        """Show a text in the place of the activity's name, and let its time go on; or write it in a log."""
        if not self._terminal:
            self.write(f"igl-spheremap: {', '.join(filter(None, (text, postfix)))}")
            return
        if self._bar is None:
            self.begin("")
        assert self._bar is not None
        self._bar.set_description_str(text, refresh=False)
        self._bar.set_postfix_str(postfix)

    def _count_loop(self, name: object, done: int, total: int, short: float = 2.0) -> None:
        """Unless the outermost loop takes few seconds, show its share that is done, and the time that is left."""
        if total < 2 or self._loop not in (None, name):
            return
        now = time.monotonic()
        if done == 0:
            self._loop, self._began, self._share = name, now, ""
        elif done == total:
            self._loop, self._share = None, ""
            if self._terminal:
                self._line(self._activity)
        elif (now - self._began) * total > short * done:
            self._share = f": {done / total:.0%}, {_duration((now - self._began) * (total - done) / done)} left"
            if self._due():
                self._line(f"{self._activity or name}{self._share}")


def measures(iterate: Iterate) -> str:
    """Format energy and residual of an iterate, if finite."""
    figures = (
        ("energy 4 pi", iterate.energy - 4 * math.pi, "+.2e"),
        ("residual", iterate.residual, ".1e"),
    )
    return ", ".join(
        f"{name} {value:{digits}}" for name, value, digits in figures if math.isfinite(value)
    )


def _duration(seconds: float) -> str:
    """A time in its two largest units.

    >>> _duration(40), _duration(100), _duration(5000), _duration(200_000)
    ('40 s', '2 min', '1 h 24 min', '2 d 7 h')
    """
    if seconds <= 60:
        return f"{math.ceil(seconds)} s"
    minutes = math.ceil(seconds / 60)
    hours, days = minutes // 60, minutes // 1440
    if days:
        return f"{days} d {hours % 24} h"
    if hours:
        return f"{hours} h {minutes % 60} min"
    return f"{minutes} min"
