"""`igl-spheremap reproduce WHAT`: the paper's tables and figures, computed anew."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from ...numbers import COUNT
from ...reproduce import ITEMS, reproduce
from ..exits import Exit

_ALL = "all"


def configure(parser: ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument(
        "names",
        metavar="WHAT",
        nargs="+",
        choices=(*ITEMS, _ALL),
        help=f"{', '.join(ITEMS)}, or {_ALL}",
    )
    parser.add_argument(
        "--meshes",
        type=Path,
        metavar="DIR",
        help="folder of real counterparts of the paper's surfaces; without it samples stand in, and "
        "nilearn's cortex if installed",
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        default=Path("reproduction"),
        help="where results and finished runs are kept (default: reproduction); run again to continue",
    )
    parser.add_argument(
        "--max-iterations", type=COUNT, metavar="N", help="of each minimisation; default: the methods' own"
    )
    parser.add_argument("-q", "--quiet", action="store_true", help="print nothing")


def run(args: Namespace) -> Exit:
    """Compute, and print the paths of what is written."""
    names = ITEMS if _ALL in args.names else tuple(dict.fromkeys(args.names))
    report = (lambda line: None) if args.quiet else args.progress.write
    written = reproduce(
        names,
        args.out,
        meshes=args.meshes,
        max_iterations=args.max_iterations,
        report=report,
        listen=args.progress.listener,
    )
    args.progress.close()
    if not args.quiet:
        print(*written, sep="\n")
    return Exit.OK
