"""Print a script that completes command lines in a shell.

    igl-spheremap completion bash > ~/.local/share/bash-completion/completions/igl-spheremap
"""

from __future__ import annotations

from argparse import Namespace

from ....errors import import_optional
from ..parser import build_parser


def run(args: Namespace) -> None:
    """Print the script."""
    shtab = import_optional("shtab", "shell completion", "completion")
    print(shtab.complete(build_parser(), shell=args.shell))
