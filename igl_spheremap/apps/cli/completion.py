"""`igl-spheremap completion SHELL`: print a completion script, made by shtab."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from ...errors import import_optional
from .command import Command
from .exits import Exit


def configure(parser: ArgumentParser) -> None:
    """Add the arguments of `completion`.

    Parameters
    ----------
    parser : ArgumentParser
        Gains them.

    Returns
    -------
    None
    """
    parser.add_argument("shell", choices=("bash", "zsh", "tcsh"), help="which shell")


def run(args: Namespace) -> Exit:
    """Print the script.

    Parameters
    ----------
    args : Namespace
        As configured.

    Returns
    -------
    Exit
        OK.
    """
    shtab = import_optional("shtab", "shell completion", "completion")
    print(shtab.complete(args.parser, shell=args.shell))
    return Exit.OK


COMMAND = Command(
    "completion",
    "print a script that completes command lines in a shell",
    """\
igl-spheremap completion bash > ~/.local/share/bash-completion/completions/igl-spheremap""",
    configure,
    run,
)
