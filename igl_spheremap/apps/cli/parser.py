"""The parser of the command line, made from the table of commands."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from collections.abc import Iterable
from typing import Any, NoReturn

from ..._version import __version__
from .arguments import SAMPLES
from .commands import COMMANDS
from .exits import HELP
from .failures import UsageError

_FILES = f"""\
files:
  .obj .off .ply .stl .glb .gltf .gii .npz and FreeSurfer's (lh.pial, lh.sphere.conformal);
  sample:NAME[:key=value,...] is a shape that the package makes itself, NAME one of
  {', '.join(SAMPLES)}
"""


class _Parser(ArgumentParser):
    """A parser that raises what goes wrong: wrong usage, and help that its stream can't take."""

    def error(self, message: str) -> NoReturn:
        raise UsageError(f"{message} (see {self.prog} --help)")

    def _print_message(self, message: str, file: Any = None) -> None:  # argparse's own hides OSErrors
        (file or sys.stderr).write(message)


def build_parser() -> ArgumentParser:
    """The parser of the command line."""
    parser = _Parser(
        prog="igl-spheremap",
        description="Conformal maps of genus-0 meshes to the unit sphere, proved free of foldings.",
        epilog=f"{_examples(command.examples[0] for command in COMMANDS)}\n{_FILES}\n{HELP}",
        formatter_class=RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"igl-spheremap {__version__}")
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for command in COMMANDS:
        purpose = command.docstring.partition("\n")[0]
        subparser = subparsers.add_parser(
            command.name,
            help=purpose[0].lower() + purpose[1:].rstrip("."),
            description=purpose,
            epilog=f"{_examples(command.examples)}\n{HELP}",
            formatter_class=RawDescriptionHelpFormatter,
        )
        for names, options in command.arguments:
            subparser.add_argument(*names, **options)
        subparser.set_defaults(row=command)
    return parser


def _examples(lines: Iterable[str]) -> str:
    return "examples:\n" + "".join(f"  {line}\n" for line in lines)
