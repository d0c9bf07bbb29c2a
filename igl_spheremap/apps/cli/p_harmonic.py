"""`igl-spheremap p-harmonic IN OUT`: minimise the p-harmonic energy, and write the map."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from ...maps.variational import p_harmonic_map
from .command import Command, UsageError
from .exits import Exit
from .map_command import add_map_arguments, map_by


def configure(parser: ArgumentParser) -> None:
    """Add the arguments of `p-harmonic`.

    Parameters
    ----------
    parser : ArgumentParser
        Gains them.

    Returns
    -------
    None
    """
    add_map_arguments(parser)
    parser.add_argument(
        "-p", type=float, metavar="P", required=True, help="the exponent, above 1; 2 is the harmonic energy"
    )
    parser.add_argument("--may-fold", action="store_true", help="take steps that fold, too")


def run(args: Namespace) -> Exit:
    """Map, write, certify what was written, and tell.

    Parameters
    ----------
    args : Namespace
        As configured.

    Returns
    -------
    Exit
        OK only with the certificate of the numbers in the file.
    """
    if not 1 < args.p < float("inf"):
        raise UsageError(f"-p {args.p:g} is out of range: give a number above 1")
    return map_by(args, lambda v, f, **options: p_harmonic_map(v, f, args.p, confine=not args.may_fold, **options))


COMMAND = Command(
    "p-harmonic",
    "map by the p-harmonic energy, which gives limbs more room for p above 2",
    """\
igl-spheremap p-harmonic sample:dino dino_sphere.obj -p 4""",
    configure,
    run,
)
