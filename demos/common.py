"""What the demos share: their arguments, their mesh, and one line for what goes wrong."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace, RawDescriptionHelpFormatter
from collections.abc import Callable, Sequence

from igl_spheremap.apps.cli import arguments
from igl_spheremap.apps.cli.exits import EXPECTED, Exit, describe
from igl_spheremap.apps.cli.inputs import InputMesh, load_source
from igl_spheremap.apps.cli.progress import Progress
from igl_spheremap.apps.viewer.app import App, open_for, run_app
from igl_spheremap.apps.viewer.choices import guess_up


def demo_parser(description: str | None, source: str) -> ArgumentParser:
    """A parser with the arguments that all demos take."""
    parser = ArgumentParser(description=description, formatter_class=RawDescriptionHelpFormatter)
    for names, options in (*arguments.source(nargs="?", default=source), *arguments.pictures()):
        parser.add_argument(*names, **options)
    return parser


def main(
    title: str,
    parser: ArgumentParser,
    build: Callable[[Namespace, InputMesh], App],
    words: Sequence[str] | None = None,
) -> int:
    """Run a demo as its arguments ask, and return its exit status."""
    args = parser.parse_args(words)
    try:
        with Progress() as args.progress:
            source = load_source(args)
        args.up = args.up or guess_up(source.name)
        open_for(args, title)
        run_app(build(args, source), args)
    except EXPECTED as error:
        status, line = describe(error)
        print(f"{parser.prog}: {line}", file=sys.stderr)
        return int(status)
    return int(Exit.OK)
