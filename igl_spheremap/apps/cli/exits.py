"""Ends of commands: exit statuses, one line for each expected error, and Ctrl-C or SIGTERM in the middle of a run."""

import signal
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from enum import IntEnum
from textwrap import fill
from types import FrameType
from typing import TYPE_CHECKING, Any

from ... import errors

if TYPE_CHECKING:
    from argparse import Namespace

    from ...verify.certificate import Certificate


class Exit(IntEnum):
    """Exit statuses with their meanings; those from 64 on are the usual ones of sysexits.h."""

    meaning: str

    def __new__(cls, status: int, meaning: str = "") -> "Exit":
        one = int.__new__(cls, status)
        one._value_, one.meaning = status, meaning
        return one

    OK = 0, "done; a map is certified folding-free"
    NO_MESH = (
        2,
        "the input can't be mapped: it is no closed genus-0 triangle mesh, or for the plane no disk",
    )
    UNCERTIFIED = (
        3,
        "not certified: foldings or overlaps remain, or vertices are off the sphere (a map is written)",
    )
    USAGE = 64, "the command line is wrong"
    UNAVAILABLE = 69, "a scheduler does not answer, or its workers can't be used"
    FAILED = 70, "the computation failed on a sound mesh, or memory ran out"
    NO_DISPLAY = (
        71,
        "nothing can be drawn here: no display for a window, no OpenGL, or no such frame",
    )
    FILE = 74, "a file can't be read or written"
    INTERRUPTED = 130, "interrupted by Ctrl-C (what was done until then is written)"
    TERMINATED = 143, "ended by SIGTERM (what was done until then is written)"


def status_help() -> str:
    """The end of a help text: all statuses with their meanings."""
    lines = (
        fill(f"  {status:<3} {status.meaning}", 80, subsequent_indent=" " * 6) for status in Exit
    )
    return "\n".join(("exit status:", *lines, ""))


def exit_of(*certificates: "Certificate") -> Exit:
    """The status of a command that wrote maps with these certificates."""
    if all(each.folding_free for each in certificates):
        return Exit.OK
    return Exit.UNCERTIFIED


class UsageError(Exception):
    """A contradiction in the command line; the message is one line."""


@contextmanager
def usage(before: str) -> Iterator[None]:
    """Raise a ValueError of an option as a UsageError, with `before` in front of its message."""
    try:
        yield
    except errors.MeshError:
        raise
    except ValueError as error:
        raise UsageError(f"{before}{error}") from None


#: The first row that fits counts: `FileError` is an OSError.
_STATUS: tuple[tuple[type[BaseException], Exit], ...] = (
    (UsageError, Exit.USAGE),
    (errors.MeshError, Exit.NO_MESH),
    (errors.FoldingsRemain, Exit.UNCERTIFIED),
    (errors.MapError, Exit.FAILED),
    (errors.FileError, Exit.FILE),
    (OSError, Exit.FILE),
    (MemoryError, Exit.FAILED),
    (ImportError, Exit.FAILED),
    (errors.FactorisationFailed, Exit.FAILED),
    (errors.DisplayError, Exit.NO_DISPLAY),
    (errors.WorkersUnavailable, Exit.UNAVAILABLE),
)

#: The flags for options of functions that are not called as these are.
_FLAGS = {
    "keep_largest": "--keep-largest",
    "holes": "--fill-holes",
    "handles": "--cut-handles",
    "triangulate": "--repair",
    "hemisphere": "--hemi",
}
#: The commands for functions that are not options of another command.
_COMMANDS = {
    "spherical_conformal_map": "map",
    "repair_foldings": "repair",
    "sphere_map": "check",
    "write_map": "map",
    "write_surface_map": "match",
    "write_coefficients": "harmonics",
}
#: Errors that take one line; any other is a defect of the package and shows its traceback.
EXPECTED = tuple(kind for kind, _ in _STATUS)


def describe(error: BaseException) -> tuple[Exit, str]:
    """The exit status and the line of an error that is one of `EXPECTED`."""
    return next(status for kind, status in _STATUS if isinstance(error, kind)), errors.one_line(
        error
    )


@dataclass(frozen=True)
class Shell:
    """Says remedies as a command's flags; those that take a value are not switches.

    >>> Shell({"--repair": False, "--fill-holes": False})(errors.Remedy("repair_mesh", {"holes": "fill"}))
    '--repair --fill-holes'
    """

    flags: Mapping[str, bool]

    def __call__(self, remedy: errors.Remedy) -> str:
        if remedy.function in _COMMANDS:
            return f"the command {_COMMANDS[remedy.function]}"
        if remedy.given == "'FILE:K'":
            return "FILE:K, as `igl-spheremap info FILE --parts` lists them"
        flags = {
            _FLAGS.get(name, f"--{name.replace('_', '-')}"): value
            for name, value in remedy.options.items()
        }
        if remedy.function.startswith("repair") and flags.keys() != {"--cut"}:
            flags = {"--repair": True} | flags
        if not flags.keys() <= self.flags.keys():
            return f"{errors.as_call(remedy)} in Python"
        words = []
        for flag, value in flags.items():
            words.append(flag)
            if self.flags[flag] and value is not None:
                words.append(str(value))
        return " ".join(words)


def shell_of(args: "Namespace") -> Shell:
    """The `Shell` of the parsed command."""
    return Shell(
        {
            name: options.get("action") != "store_true"
            for names, options in args.row.arguments
            for name in names
        }
    )


#: Signals that ask a command to end. On Windows other programs can't send SIGTERM, but Ctrl-Break.
_SIGNALS = {
    signal.SIGINT: Exit.INTERRUPTED,
    signal.SIGTERM: Exit.TERMINATED,
    getattr(signal, "SIGBREAK", signal.SIGTERM): Exit.TERMINATED,
}


class Interrupt:
    """A listener that ends the run at the next event after one of `_SIGNALS`; a second one ends it at once.

    A context manager: signals are caught inside. `announce` is called at the first one.
    """

    def __init__(self, announce: Callable[[], None] = lambda: None) -> None:
        self.asked = 0  # the signal's number
        self._announce = announce
        self._before: dict[signal.Signals, Any] = {}

    def __call__(self, event: object) -> None:
        """If a signal came, end the run."""
        if self.asked:
            raise StopIteration

    @property
    def status(self) -> Exit:
        """The exit status for the signal that came."""
        return _SIGNALS[signal.Signals(self.asked)]

    def __enter__(self) -> "Interrupt":
        # elsewhere signals can't be caught
        if threading.current_thread() is threading.main_thread():
            self._before = {number: signal.signal(number, self._ask) for number in _SIGNALS}
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _ask(self, number: int, frame: FrameType | None) -> None:
        self.asked = number
        for each in _SIGNALS:
            signal.signal(each, signal.SIG_DFL)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        self._announce()
