"""`reproduce`: the paper's tables and figures."""

from argparse import Namespace

from ...reproduce.items import ALL, ITEMS, reproduce


def run_reproduce(args: Namespace) -> None:
    names = ITEMS if ALL in args.names else tuple(dict.fromkeys(args.names))
    written = reproduce(
        names,
        args.out,
        meshes=args.meshes,
        max_iterations=args.max_iterations,
        report=(lambda line: None) if args.quiet else args.progress.write,
    )
    if not args.quiet:
        print(*written, sep="\n")
