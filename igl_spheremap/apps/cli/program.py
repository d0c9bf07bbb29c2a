"""One run of the command `igl-spheremap`: parse, run, and turn every failure into one line and an exit status.

Nothing here takes time to import, so that Ctrl-C is caught at once.
"""

import contextlib
import io
import math
import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence

from ...errors import said_by
from ...operators.factor.memory import OF_ANY_MAP, bytes_left, too_little
from .exits import EXPECTED, Exit, describe, shell_of


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command line, by default that of this process, and return the exit status.

    >>> main(["info", "sample:sphere", "--quiet"])
    0
    """
    with contextlib.ExitStack() as imports, contextlib.ExitStack() as saying:
        # An exception in the middle of an import would come out of libigl's as another one, or abort the process.
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            with contextlib.suppress(ValueError):  # not the main thread
                imports.callback(
                    signal.signal, signal.SIGINT, signal.signal(signal.SIGINT, _end_at_once)
                )
        try:
            _guard_streams()
            if arguments is None:
                arguments = sys.argv[1:]
            status = _run(list(arguments), imports.close, saying)
            if sys.stdout is not None:
                sys.stdout.flush()
            return status
        except _Terminated:
            return _fail(Exit.TERMINATED, "terminated")
        except KeyboardInterrupt:
            return _fail(Exit.INTERRUPTED, "interrupted by you")
        except EXPECTED as error:
            if isinstance(error, OSError):
                _drop_output()
            if isinstance(error, BrokenPipeError):  # the reader of our output left, as `head` does
                return int(Exit.FILE)
            return _fail(*describe(error))


def _end_at_once(*_: object) -> None:
    os.write(2, b"igl-spheremap: interrupted by you\n")
    os._exit(Exit.INTERRUPTED)


class _Terminated(BaseException):
    """SIGTERM came."""


@contextlib.contextmanager
def _terminable() -> Iterator[None]:
    """Inside, SIGTERM ends the command as Ctrl-C does, so that no process, semaphore or temporary file stays."""
    try:
        before = signal.signal(signal.SIGTERM, _terminate)
    except ValueError:  # not the main thread
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _terminate(*_: object) -> None:
    raise _Terminated


def _run(words: list[str], imported: Callable[[], None], saying: contextlib.ExitStack) -> int:
    """Run one command line; `imported` is called when all is imported and the command's work begins.

    Until `saying` is closed, remedies are said as flags of the command.
    """
    from .parser import build_parser

    parser = build_parser(words)
    if not words:
        parser.print_help(sys.stdout)
        return Exit.OK
    try:
        args = parser.parse(words)
    except SystemExit:  # --help and --version
        return Exit.OK
    if bytes_left() < math.inf:  # each further thread of BLAS would take 40 MB, three times
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if bytes_left() < OF_ANY_MAP:
        raise too_little(OF_ANY_MAP)
    from .progress import Progress  # imports numpy, which --help does not need

    args.words, run = words, args.row.run
    imported()
    saying.enter_context(said_by(shell_of(args)))
    with _terminable(), Progress(quiet=getattr(args, "quiet", False)) as args.progress:
        return int(run(args) or Exit.OK)


def _guard_streams() -> None:
    """Keep files off the descriptors of closed streams, and escape what a stream's encoding lacks."""
    for name in ("stdin", "stdout", "stderr"):
        if getattr(sys, name) is None:
            # takes the lowest free descriptor, which is this stream's
            os.open(os.devnull, os.O_RDWR)
    if sys.stderr is None:  # print(file=None) would print to stdout
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _drop_output() -> None:
    """Send stdout to nowhere if it takes no more, so that Python's flush at its end does not fail."""
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _fail(status: Exit, line: str) -> int:
    with contextlib.suppress(OSError):  # stderr may be full, too
        print(f"igl-spheremap: {line}", file=sys.stderr, flush=True)
    return int(status)
