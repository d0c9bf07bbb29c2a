"""One run of the command `igl-spheremap`: parse, run, and turn every failure into one line and an exit status."""

from __future__ import annotations

import contextlib
import io
import os
import sys
from collections.abc import Callable

from .exits import Exit
from .failures import EXPECTED, describe
from .parser import build_parser


def run(words: list[str], started: Callable[[], None]) -> int:
    """Run one command line, and turn expected errors into one line and an exit status.

    `started` is called when everything is imported and the command's work begins.
    """
    try:
        _guard_streams()
        status = _run(words, started)
        if sys.stdout is not None:
            sys.stdout.flush()
        return status
    except KeyboardInterrupt:
        return _fail(Exit.INTERRUPTED, "interrupted")
    except EXPECTED as error:
        if isinstance(error, OSError):
            _drop_output()
        if isinstance(error, BrokenPipeError):  # the reader of our output left, as `head` does
            return int(Exit.FILE)
        return _fail(*describe(error))
    finally:
        started()


def _run(words: list[str], started: Callable[[], None]) -> int:
    try:
        args = build_parser().parse_args(words)
    except SystemExit:  # --help and --version
        return Exit.OK
    from .progress import Progress  # imports numpy, which --help does not need

    args.words = words
    module = args.row.module
    started()
    with Progress(quiet=getattr(args, "quiet", False)) as args.progress:
        return int(module.run(args) or Exit.OK)


def _guard_streams() -> None:
    """Keep files off the descriptors of closed streams, and escape what a stream's encoding lacks."""
    for name in ("stdin", "stdout", "stderr"):
        if getattr(sys, name) is None:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest free descriptor, which is this stream's
    if sys.stderr is None:  # print(file=None) would print to stdout
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _drop_output() -> None:
    """Let Python's own flush at its end succeed where stdout takes no more."""
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _fail(status: Exit, line: str) -> int:
    with contextlib.suppress(OSError):  # stderr may be full, too
        print(f"igl-spheremap: {line}", file=sys.stderr, flush=True)
    return int(status)
