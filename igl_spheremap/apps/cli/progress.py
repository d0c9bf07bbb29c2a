"""What a command does now, as one line on a terminal, drawn by tqdm; of many files a line a minute in logs."""

import logging
import math
import sys
import time
from collections.abc import Callable
from typing import Any

from tqdm import tqdm

from ...mesh.arrays import IntArray
from ...mesh.timings import LOGGER
from ...result.run import Iterate, Listener, title_of
from ...verify.signs import folded_faces

#: Stages of the library that take long on large meshes, by what they do.
_LONG = {"factorisation": "factorising", "repair": "finishing the map", "certificate": "certifying"}
_PLAIN = "{desc} [{elapsed}]"
_ITERATES = "{desc} [{elapsed}{postfix}]"
_INTERVAL = 0.5  # seconds; foldings are counted anew for each line
_LOG_INTERVAL = 60.0  # seconds between the lines of a log


class Progress(logging.Handler):
    """A context that shows one stage at a time and leaves the terminal clean; silent on any other stream.

    Stages are those of the command, and some that the library logs.
    """

    def __init__(self, quiet: bool = False) -> None:
        super().__init__(logging.INFO)
        self._quiet = quiet
        self._bar: tqdm[Any] | None = None
        self._iterating = False

    def __enter__(self) -> "Progress":
        LOGGER.addHandler(self)
        LOGGER.setLevel(logging.INFO)
        return self

    def __exit__(self, *_: object) -> None:
        LOGGER.removeHandler(self)
        LOGGER.setLevel(logging.NOTSET)
        self.close()

    def emit(self, record: logging.LogRecord) -> None:
        """Show a stage of the library."""
        if record.msg in _LONG:
            self.stage(_LONG[record.msg])

    def stage(self, name: str) -> None:
        """Begin a stage."""
        self._open(name, _PLAIN)

    def steps(self, name: str, total: int) -> Callable[[], object]:
        """Begin a stage of so many steps; call the result for each."""
        self._open(name, None, total=total, unit="step")
        assert self._bar is not None
        return self._bar.update

    def count(self, name: str, total: int) -> Callable[[bool, bool], None]:
        """Begin a stage that goes through files; call the result for each: is its map certified, was it made before?

        On a terminal it is a bar; elsewhere at most a line a minute says how many are done, and when all will be.
        """
        self._open(name, None, total=total, unit="mesh")
        began = said = time.monotonic()
        done = failed = new = 0

        def take(certified: bool, made_before: bool) -> None:
            nonlocal done, failed, new, said
            done, failed, new = done + 1, failed + (not certified), new + (not made_before)
            assert self._bar is not None
            self._bar.update()
            if not certified:
                self._bar.set_postfix_str(f"{failed} failed")
            now = time.monotonic()
            if self._bar.disable and not self._quiet and new and done < total and now - said >= _LOG_INTERVAL:
                said = now
                rate = new / max(now - began, 1e-3)
                left = _duration((total - done) / rate)
                self.write(f"igl-spheremap: {name}: {done} of {total} files done, {failed} failed; "
                           f"{60 * rate:.3g} a minute, {left} left")

        return take

    def listener(self, f: IntArray) -> Listener:
        """A listener that shows iterates of a map with faces `f`: energy, residual and foldings."""

        def show(iterate: Iterate) -> None:
            name = title_of(iterate)
            if not self._iterating:
                self._open(name, _ITERATES, mininterval=_INTERVAL, miniters=1)
                self._iterating = True
            assert self._bar is not None
            self._bar.set_description_str(name, refresh=False)
            if self._bar.update():
                foldings = int(folded_faces(iterate.x, f).sum())
                self._bar.set_postfix_str(f"{measures(iterate)}, foldings {foldings}")

        return show

    def write(self, line: str) -> None:
        """Print a line on stderr that stays."""
        tqdm.write(line, file=sys.stderr)
        sys.stderr.flush()

    def close(self) -> None:
        """Clear the line."""
        if self._bar is not None:
            self._bar.close()
        self._bar, self._iterating = None, False

    def _open(self, name: str, bar_format: str | None, **options: Any) -> None:
        self.close()
        self._bar = tqdm(
            desc=name,
            bar_format=bar_format,
            disable=True if self._quiet else None,  # None: unless stderr is a terminal
            leave=False,
            dynamic_ncols=True,
            file=sys.stderr,
            **options,
        )


def measures(iterate: Iterate) -> str:
    """Energy above 4 pi and residual of an iterate, those that are finite."""
    figures = {"energy 4 pi": f"{iterate.energy - 4 * math.pi:+.2e}", "residual": f"{iterate.residual:.1e}"}
    finite = (math.isfinite(iterate.energy), math.isfinite(iterate.residual))
    return ", ".join(f"{name} {value}" for (name, value), shown in zip(figures.items(), finite, strict=True) if shown)


def _duration(seconds: float) -> str:
    """A time in its two largest units.

    >>> _duration(40), _duration(5000), _duration(200_000)
    ('1 min', '1 h 24 min', '2 d 7 h')
    """
    minutes = math.ceil(seconds / 60)
    hours, days = minutes // 60, minutes // 1440
    if days:
        return f"{days} d {hours % 24} h"
    return f"{hours} h {minutes % 60} min" if hours else f"{minutes} min"
