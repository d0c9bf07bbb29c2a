"""`reproduce`: the paper's tables and figures."""

from argparse import Namespace

from ...reproduce.items import ALL, DRAWN, ITEMS, WRITTEN, reproduce
from ..arguments import refuse_flags


def run_reproduce(args: Namespace) -> None:
    """Compute the paper's tables and figures, beside its own numbers.

    igl-spheremap reproduce table2
    igl-spheremap reproduce all --meshes meshes --out reproduction
    """
    names = ITEMS if ALL in args.names else tuple(dict.fromkeys(args.names))
    for flag, kind, needed in (("--page", "table", WRITTEN), ("--format", "figure", DRAWN)):
        if not set(names) & set(needed):
            refuse_flags(args, (flag,), f"{' '.join(names)}, which is no {kind},")
    written = reproduce(
        names,
        args.out,
        meshes=args.meshes,
        max_iterations=args.max_iterations,
        page=args.page,
        suffix=args.format,
        report=(lambda line: None) if args.quiet else args.progress.write,
    )
    if not args.quiet:
        print(*written, sep="\n")
