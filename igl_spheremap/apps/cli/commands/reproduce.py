"""`reproduce`: the paper's tables and figures."""

from argparse import Namespace

from ...reproduce.items import ALL, ITEMS, reproduce


def run_reproduce(args: Namespace) -> None:
    names, report = tuple(dict.fromkeys(args.names)), args.progress.write
    if ALL in names:
        names = tuple(ITEMS)
    if args.quiet:
        report = _say_nothing
    written = reproduce(
        names,
        args.out,
        meshes=args.meshes,
        max_iterations=args.max_iterations,
        report=report,
    )
    if not args.quiet:
        print(*written, sep="\n")


def _say_nothing(line: str) -> None:
    pass
