"""The command line: `main` starts it, `commands` lists what it can do."""

from __future__ import annotations

import os
import signal
import sys

TYPE_CHECKING = False  # `typing` would take most of the time until Ctrl-C is caught
if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Any

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command line, by default that of this process, and return the exit status.

    >>> main(["info", "sample:sphere", "--quiet"])
    0
    """
    # An exception in the middle of an import would come out of libigl's as another one, or abort the process.
    before: Any = signal.getsignal(signal.SIGINT)
    if before is signal.default_int_handler:
        try:  # noqa: SIM105 - an import more
            signal.signal(signal.SIGINT, _exit)
        except ValueError:  # not the main thread
            pass
    from .program import run

    return run(list(sys.argv[1:] if arguments is None else arguments), lambda: _restore(before))


def _exit(*_: object) -> None:
    os.write(2, b"igl-spheremap: interrupted\n")
    os._exit(130)


def _restore(handler: Any) -> None:
    if signal.getsignal(signal.SIGINT) is _exit:
        signal.signal(signal.SIGINT, handler)
