"""`igl-spheremap repair SOURCE SPHERE OUT`: mend the foldings of a map, from whatever program it comes."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import Any

import numpy as np

from ...io import certify_radius, write_map
from ...maps.repair_foldings import repair_foldings
from ...verify.distortion import angle_differences
from ...verify.figures import angle_figures
from .command import Command
from .exits import Exit
from .output import add_output, angle_row, certificate_figures, check_json, put_out, row
from .pair import add_pair, load_pair
from .streams import check_target, write_target

_ROUNDING = 1e-14  # positions that differ by less count as unmoved


def configure(parser: ArgumentParser) -> None:
    """Add the arguments of `repair`.

    Parameters
    ----------
    parser : ArgumentParser
        Gains them.

    Returns
    -------
    None
    """
    add_pair(parser, "SOURCE")
    parser.add_argument("target", metavar="OUT", help="the mended map, same vertex order and radius; - for stdout")
    parser.add_argument("-f", "--force", action="store_true", help="replace OUT if it exists")
    add_output(parser)


def run(args: Namespace) -> Exit:
    """Mend, write, certify what was written, and tell.

    Parameters
    ----------
    args : Namespace
        As configured.

    Returns
    -------
    Exit
        OK only with the certificate of the numbers in the file.
    """
    check_target(args)
    check_json(args)
    source, name, x = load_pair(args)
    before = certify_radius(x, source.f)
    result = repair_foldings(source.v, source.f, x)
    written = write_target(
        args,
        lambda path: write_map(path, result, force=args.force, radius=before.radius, metadata=source.metadata),
    )
    unit = x / np.linalg.norm(x, axis=1, keepdims=True)
    moved = int((np.linalg.norm(result.sphere - unit, axis=1) > _ROUNDING).sum())
    angles = [angle_figures(angle_differences(source.v, source.f, each)) for each in (unit, result.sphere)]
    figures: dict[str, Any] = {
        "source": source.name, "repairs": source.repairs, "sphere": name, "target": args.target,
        "vertices": len(x), "faces": len(source.f), "moved": moved, "seconds": result.seconds,
        "before": {"certificate": certificate_figures(before.certificate), "angle_differences": angles[0]},
        "after": {"certificate": certificate_figures(written.certificate), "angle_differences": angles[1]},
    }  # fmt: skip
    summary = [
        row("source", f"{source.name}: {len(x)} vertices, {len(source.f)} faces"),
        row("before", f"{name}: {before.certificate}"),
        angle_row(angles[0]),
        row("after", f"{args.target}: {written.certificate}"),
        angle_row(angles[1]),
        row("moved", f"{moved} vertices, in {result.seconds:.2f} s"),
    ]
    put_out(args, figures, "\n".join(summary))
    return Exit.OK if written.certificate.folding_free else Exit.FOLDINGS


COMMAND = Command(
    "repair",
    "mend the foldings of a map, from whatever program it comes",
    "igl-spheremap repair lh.pial their.sphere mended.sphere",
    configure,
    run,
)
