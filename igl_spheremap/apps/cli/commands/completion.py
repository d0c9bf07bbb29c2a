"""`igl-spheremap completion SHELL`: print a completion script, made by shtab."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from ....errors import import_optional
from ..exits import Exit


def configure(parser: ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("shell", choices=("bash", "zsh", "tcsh"), help="which shell")


def run(args: Namespace) -> Exit:
    """Print the script."""
    from ..parser import build_parser  # imports all commands, which only this one needs

    shtab = import_optional("shtab", "shell completion", "completion")
    print(shtab.complete(build_parser(), shell=args.shell))
    return Exit.OK
