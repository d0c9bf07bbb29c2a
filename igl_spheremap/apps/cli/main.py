"""The command `igl-spheremap`: parse, run, and turn every failure into one line and an exit status."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

from ..._version import __version__
from . import (
    batch,
    check,
    completion,
    export,
    grid,
    harmonics,
    info,
    landmarks,
    map_command,
    p_harmonic,
    repair,
    reproduce,
    resample,
    view,
)
from .command import Command
from .exits import HELP, Exit
from .failures import EXPECTED, told

_MODULES = (
    map_command,
    check,
    info,
    view,
    repair,
    resample,
    export,
    harmonics,
    grid,
    batch,
    p_harmonic,
    landmarks,
    reproduce,
    completion,
)
#: All subcommands. A further one is a module with a COMMAND, and a word above.
COMMANDS: tuple[Command, ...] = tuple(module.COMMAND for module in _MODULES)

_DESCRIPTION = "Conformal maps of genus-0 meshes to the unit sphere, proved free of foldings."
_FILES = """\
files:
  .obj .off .ply .stl .glb .gltf .gii .npz and FreeSurfer's (lh.pial, lh.sphere);
  sample:NAME[:key=value,...] is a shape that the package makes itself
"""


class _Parser(argparse.ArgumentParser):
    """A parser whose complaints take one line, and not the exit status of a bad mesh."""

    def error(self, message: str) -> NoReturn:
        self.exit(Exit.USAGE, f"igl-spheremap: {message} (see {self.prog} --help)\n")


def build_parser() -> argparse.ArgumentParser:
    """The parser of the whole command line.

    Returns
    -------
    argparse.ArgumentParser
        With one subparser per command.
    """
    plain: dict[str, Any] = {"formatter_class": argparse.RawDescriptionHelpFormatter}
    examples = "".join(f"  {command.examples.splitlines()[0]}\n" for command in COMMANDS)
    parser = _Parser(
        prog="igl-spheremap",
        description=_DESCRIPTION,
        **plain,
        epilog=f"examples:\n{examples}\n{_FILES}\n{HELP}",
    )
    parser.add_argument("--version", action="version", version=f"igl-spheremap {__version__}")
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for command in COMMANDS:
        lines = "".join(f"  {line}\n" for line in command.examples.splitlines())
        one = subparsers.add_parser(
            command.name,
            help=command.help,
            description=f"{command.help[0].upper()}{command.help[1:]}.",
            epilog=f"examples:\n{lines}\n{HELP}",
            **plain,
        )
        command.configure(one)
        one.set_defaults(run=command.run, parser=parser)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command line.

    Parameters
    ----------
    arguments : sequence of str, optional
        The words after the command's name; by default those of this process.

    Returns
    -------
    int
        The exit status, see `Exit`.

    Examples
    --------
    >>> main(["info", "sample:sphere", "--quiet"])
    0
    """
    try:
        args = build_parser().parse_args(arguments)
        args.words = list(sys.argv[1:] if arguments is None else arguments)
        return int(args.run(args))
    except SystemExit as error:  # argparse: --help, --version and its complaints
        return int(error.code or 0)
    except KeyboardInterrupt:
        return _fail(Exit.INTERRUPTED, "interrupted")
    except BrokenPipeError:  # the reader of our output left, as `head` does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return int(Exit.FILE)
    except EXPECTED as error:
        return _fail(*told(error))


def _fail(status: Exit, line: str) -> int:
    print(f"igl-spheremap: {line}", file=sys.stderr)
    return int(status)
