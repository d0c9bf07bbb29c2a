"""What a subcommand is: one file each, and a word in the table of `main`."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from dataclasses import dataclass

from .exits import Exit


class UsageError(Exception):
    """The command line makes no sense; the message is one line."""


@dataclass(frozen=True)
class Command:
    """A subcommand.

    Attributes
    ----------
    name : str
        As it is typed.
    help : str
        What it does, in a phrase.
    examples : str
        Command lines that show it, without the indentation.
    configure : callable
        Adds the arguments to a parser.
    run : callable
        Does it; takes the parsed arguments, gives the exit status.
    """

    name: str
    help: str
    examples: str
    configure: Callable[[ArgumentParser], None]
    run: Callable[[Namespace], Exit]
