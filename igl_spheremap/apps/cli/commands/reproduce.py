"""`reproduce`: the paper's tables and figures."""

from argparse import Namespace

from ...reproduce.items import ALL, ITEMS, reproduce


def run_reproduce(args: Namespace) -> None:
    names = tuple(dict.fromkeys(args.names))
    if ALL in names:
        names = tuple(ITEMS)

    def report(line: str) -> None:
        if not args.quiet:
            args.progress.write(line)

    written = reproduce(
        names,
        args.out,
        meshes=args.meshes,
        max_iterations=args.max_iterations,
        report=report,
    )
    if not args.quiet:
        print(*written, sep="\n")
