"""What the demos share: their arguments, their mesh, and one line for what goes wrong."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace, RawDescriptionHelpFormatter
from collections.abc import Callable, Sequence

from igl_spheremap.apps.cli.exits import Exit
from igl_spheremap.apps.cli.failures import EXPECTED, describe
from igl_spheremap.apps.cli.progress import Progress
from igl_spheremap.apps.cli.source import Source, add_repair, load_source
from igl_spheremap.apps.cli.streams import add_format
from igl_spheremap.apps.viewer import UPS, App, add_picture_arguments, guess_up, open_for, run_app


def demo_parser(description: str | None, source: str) -> ArgumentParser:
    """A parser with the arguments that all demos take."""
    parser = ArgumentParser(description=description, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument(
        "source",
        nargs="?",
        default=source,
        metavar="IN",
        help=f"a mesh file, - for stdin, or sample:NAME[:key=value,...] (default {source})",
    )
    parser.add_argument("--up", choices=tuple(UPS), help="which way is up (default z, but y for .obj, .glb, .gltf)")
    add_format(parser)
    add_repair(parser)
    add_picture_arguments(parser)
    return parser


def main(
    title: str,
    parser: ArgumentParser,
    build: Callable[[Namespace, Source], App],
    arguments: Sequence[str] | None = None,
) -> int:
    """Run a demo as its arguments ask, and return its exit status."""
    args = parser.parse_args(arguments)
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
