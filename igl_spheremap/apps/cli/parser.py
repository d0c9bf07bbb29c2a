"""The parser of the command line, made from the table of commands."""

from __future__ import annotations

from argparse import ArgumentParser, RawDescriptionHelpFormatter
from typing import NoReturn

from ..._version import __version__
from .commands import COMMANDS
from .exits import HELP, Exit

#: Written out, for the package of samples imports numpy.
SAMPLES = ("bird", "brain", "dino", "dumbbell", "octopus", "pear", "sphere", "spheroid", "spring")
_FILES = f"""\
files:
  .obj .off .ply .stl .glb .gltf .gii .npz and FreeSurfer's (lh.pial, lh.sphere.conformal);
  sample:NAME[:key=value,...] is a shape that the package makes itself, NAME one of
  {', '.join(SAMPLES)}
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
