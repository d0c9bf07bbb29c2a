"""`igl-spheremap resample IN SPHERE OUT`: a surface with the connectivity of a regular sphere."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...io import read_sphere, write_mesh
from ...mesh.check import check_faces
from ...shapes.locate import SphereLocator
from ...shapes.transfer import interpolate, regular_mesh
from .command import Command, UsageError
from .exits import Exit
from .output import add_output, check_json, put_out, row
from .pair import add_pair, load_pair
from .streams import check_target, target_format, write_target


def configure(parser: ArgumentParser) -> None:
    """Add the arguments of `resample`.

    Parameters
    ----------
    parser : ArgumentParser
        Gains them.

    Returns
    -------
    None
    """
    add_pair(parser, "IN")
    parser.add_argument("target", metavar="OUT", help="the resampled surface; - for stdout")
    parser.add_argument(
        "--to",
        metavar="MESH",
        default="ico:5",
        help="ico:K, an icosahedron cut K times (10 * 4^K + 2 vertices), or a file with a sphere mesh, "
        "such as another surface's map; default: ico:5",
    )
    parser.add_argument("-f", "--force", action="store_true", help="replace OUT if it exists")
    add_output(parser)


def run(args: Namespace) -> Exit:
    """Locate the new vertices on the map, interpolate, write, and tell.

    Parameters
    ----------
    args : Namespace
        As configured.

    Returns
    -------
    Exit
        OK; a map that folds is refused with FOLDINGS.
    """
    check_target(args)
    check_json(args)
    points, faces = _target_sphere(args.to)
    source, name, x = load_pair(args)
    locator = SphereLocator(x / np.median(np.linalg.norm(x, axis=1)), source.f)
    v = interpolate(source.v, source.f, locator.locate(points))
    write_target(args, lambda path: write_mesh(path, v, faces, force=args.force, metadata=source.metadata))
    figures: dict[str, Any] = {
        "source": source.name, "sphere": name, "to": args.to, "target": args.target,
        "vertices": len(v), "faces": len(faces),
    }  # fmt: skip
    summary = [
        row("source", f"{source.name}: {len(source.v)} vertices, {len(source.f)} faces"),
        row("sphere", f"{name}, resampled at the vertices of {args.to}"),
        row(
            "written", f"{args.target} ({target_format(args).name}): {len(v)} vertices, {len(faces)} faces"
        ),
    ]
    put_out(args, figures, "\n".join(summary))
    return Exit.OK


def _target_sphere(to: str) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    if not to.startswith("ico:"):
        x, f = read_sphere(to)
        return x, check_faces(f, len(x))
    try:
        return regular_mesh(to)
    except ValueError as error:
        raise UsageError(f"--to {error}") from None


COMMAND = Command(
    "resample",
    "give a surface the connectivity of a regular sphere, or of another map",
    """\
igl-spheremap resample lh.pial lh.sphere lh_ico5.surf.gii --to ico:5
igl-spheremap resample sub01.ply sub01_sphere.ply sub01_on_sub02.ply --to sub02_sphere.ply""",
    configure,
    run,
)
