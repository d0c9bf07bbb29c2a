"""`igl-spheremap p-harmonic IN OUT`: minimise the p-harmonic energy, and write the map."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from ....maps.p_harmonic import p_harmonic_map
from ...numbers import number
from ..exits import Exit
from ..mapping import add_map_arguments, add_may_fold, map_by

_EXPONENT = number("above 1", lambda p: p > 1)


def configure(parser: ArgumentParser) -> None:
    """Add the arguments."""
    add_map_arguments(parser)
    parser.add_argument(
        "-p", type=_EXPONENT, metavar="P", required=True, help="the exponent, above 1; 2 is the harmonic energy"
    )
    add_may_fold(parser)


def run(args: Namespace) -> Exit:
    """Map p-harmonically."""
    injective = not args.may_fold
    return map_by(args, lambda v, f, **options: p_harmonic_map(v, f, args.p, keep_injective=injective, **options))
