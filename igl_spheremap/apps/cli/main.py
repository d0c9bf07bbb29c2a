"""The command `igl-spheremap`: parse, run, and turn every failure into one line and an exit status."""

from __future__ import annotations

import io
import os
import sys
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from collections.abc import Sequence
from typing import NoReturn

from ..._version import __version__
from .commands import COMMANDS
from .exits import HELP, Exit
from .failures import EXPECTED, describe

_FILES = """\
files:
  .obj .off .ply .stl .glb .gltf .gii .npz and FreeSurfer's (lh.pial, lh.sphere);
  sample:NAME[:key=value,...] is a shape that the package makes itself
"""


class _Parser(ArgumentParser):
    """A parser whose errors take one line, and not the exit status of a bad mesh."""

    def error(self, message: str) -> NoReturn:
        self.exit(Exit.USAGE, f"igl-spheremap: {message} (see {self.prog} --help)\n")


def build_parser(only: str | None = None) -> ArgumentParser:
    """The parser of the command line, with the arguments of one command, or of all."""
    parser = _Parser(
        prog="igl-spheremap",
        description="Conformal maps of genus-0 meshes to the unit sphere, proved free of foldings.",
        epilog=f"{_examples(*(command.examples.splitlines()[0] for command in COMMANDS))}\n{_FILES}\n{HELP}",
        formatter_class=RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"igl-spheremap {__version__}")
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for command in COMMANDS:
        subparser = subparsers.add_parser(
            command.name,
            help=command.help,
            description=f"{command.help[0].upper()}{command.help[1:]}.",
            epilog=f"{_examples(*command.examples.splitlines())}\n{HELP}",
            formatter_class=RawDescriptionHelpFormatter,
        )
        if only in (None, command.name):
            command.module.configure(subparser)
            subparser.set_defaults(run=command.module.run)
    return parser


def _examples(*lines: str) -> str:
    return "examples:\n" + "".join(f"  {line}\n" for line in lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command line, by default that of this process, and return the exit status.

    >>> main(["info", "sample:sphere", "--quiet"])
    0
    """
    try:
        _guard_streams()
        status = _run(list(sys.argv[1:] if arguments is None else arguments))
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


def _run(words: list[str]) -> int:
    try:
        args = build_parser(words[0] if words else "").parse_args(words)
    except SystemExit as end:  # --help, --version, or an error of usage
        return int(end.code or 0)
    from .progress import Progress  # imports numpy, which --help does not need

    args.words = words
    with Progress(quiet=getattr(args, "quiet", False)) as args.progress:
        return int(args.run(args))


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
    print(f"igl-spheremap: {line}", file=sys.stderr)
    return int(status)
