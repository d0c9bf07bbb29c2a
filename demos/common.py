"""What the demos share: their arguments, their mesh, and one line for what goes wrong."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace, RawDescriptionHelpFormatter
from collections.abc import Callable, Sequence

from igl_spheremap.apps.cli.command import UsageError
from igl_spheremap.apps.cli.exits import Exit
from igl_spheremap.apps.cli.source import Source, add_repair, load_source
from igl_spheremap.apps.cli.streams import add_format
from igl_spheremap.apps.viewer import UPS, App, add_picture_arguments, guess_up, open_for, run_app
from igl_spheremap.errors import DisplayError, FileError, MapError, MeshError

_STATUS = {MeshError: Exit.NO_MESH, FileError: Exit.FILE, UsageError: Exit.USAGE}


def load(name: str) -> Source:
    """The mesh of a file or of sample:NAME."""
    return load_source(Namespace(source=name, repair=False, keep_largest=False))


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
        source = load_source(args)
        args.up = args.up or guess_up(source.name)
        open_for(args, title)
        run_app(build(args, source), args)
    except (MeshError, FileError, UsageError, DisplayError, MapError) as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return int(_STATUS.get(type(error), Exit.FAILED))
    return int(Exit.OK)
