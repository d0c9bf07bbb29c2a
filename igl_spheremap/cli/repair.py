"""`igl-spheremap repair SOURCE SPHERE OUT`: mend the foldings of a map, from whatever program it comes."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..distortion import angle_differences
from ..errors import MeshError
from ..io import certify_radius, check_writable, format_of, write_sphere
from ..repair.embedding import progressive_embedding
from .command import Command
from .exits import Exit
from .output import add_output, angle_figures, angle_row, certificate_figures, check_json, put_out, row
from .pair import add_pair, load_pair


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
    parser.add_argument("target", metavar="OUT", help="the mended map, same vertex order and radius")
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
    format_of(args.target)
    check_writable(args.target, args.force)
    check_json(args)
    source, name, x = load_pair(args)
    before = certify_radius(x, source.f)
    length = np.linalg.norm(x, axis=1)
    bad = np.flatnonzero(~(np.isfinite(length) & (length > 0)))
    if len(bad):
        raise MeshError(
            f"{name} has {len(bad)} vertices without a direction, e.g. {bad[0]}; give each a nonzero one"
        )
    y = progressive_embedding(x / length[:, None], source.f)
    written = write_sphere(
        args.target, y, source.f, force=args.force, radius=before.radius, metadata=source.metadata
    )
    moved = int((np.linalg.norm(y - x / length[:, None], axis=1) > 1e-15).sum())
    angles = [_angles(source.v, source.f, position) for position in (x, y)]
    figures: dict[str, Any] = {
        "source": source.name, "repairs": source.repairs, "sphere": name, "target": args.target,
        "vertices": len(x), "faces": len(source.f), "moved": moved,
        "before": {"certificate": certificate_figures(before.certificate), "angle_differences": angles[0]},
        "after": {"certificate": certificate_figures(written.certificate), "angle_differences": angles[1]},
    }  # fmt: skip
    summary = [
        row("source", f"{source.name}: {len(x)} vertices, {len(source.f)} faces"),
        row("before", f"{name}: {before.certificate}"),
        angle_row(angles[0]),
        row("after", f"{args.target}: {written.certificate}"),
        angle_row(angles[1]),
        row("moved", f"{moved} vertices"),
    ]
    put_out(args, figures, "\n".join(summary))
    return Exit.OK if written.certificate.folding_free else Exit.FOLDINGS


def _angles(v: NDArray[np.float64], f: NDArray[np.int64], x: NDArray[np.float64]) -> dict[str, float]:
    return angle_figures(angle_differences(v, f, x))


COMMAND = Command(
    "repair",
    "mend the foldings of a map, from whatever program it comes",
    "igl-spheremap repair lh.pial their.sphere mended.sphere",
    configure,
    run,
)
