"""`igl-spheremap reproduce WHAT`: the paper's tables and figures, computed anew."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from pathlib import Path

from ..reproduce import ITEMS, reproduce
from .command import Command
from .exits import Exit

_ALL = "all"


def configure(parser: ArgumentParser) -> None:
    """Add the arguments of `reproduce`.

    Parameters
    ----------
    parser : ArgumentParser
        Gains them.

    Returns
    -------
    None
    """
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
        help="where results and finished runs are kept (default: reproduction); run again to go on",
    )
    parser.add_argument(
        "--max-iterations", type=int, metavar="N", help="cap of each minimisation; default: the methods' own"
    )
    parser.add_argument("-q", "--quiet", action="store_true", help="say nothing")


def run(args: Namespace) -> Exit:
    """Compute, and say what is going on.

    Parameters
    ----------
    args : Namespace
        As configured.

    Returns
    -------
    Exit
        OK when all is written.
    """

    def tell(line: str) -> None:
        if not args.quiet:
            print(line, file=sys.stderr, flush=True)

    names = ITEMS if _ALL in args.names else tuple(dict.fromkeys(args.names))
    written = reproduce(names, args.out, meshes=args.meshes, max_iterations=args.max_iterations, tell=tell)
    if not args.quiet:
        for path in written:
            print(path)
    return Exit.OK


COMMAND = Command(
    "reproduce",
    "compute the paper's tables and figures anew, beside its own numbers",
    """\
igl-spheremap reproduce table2
igl-spheremap reproduce all --meshes ../shared/meshes --out reproduction""",
    configure,
    run,
)
