"""`igl-spheremap view IN`: the surface beside its sphere, in a window or as a picture."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ....errors import MeshError
from ....io import read_map
from ....maps.options import METHODS
from ....maps.spherical_conformal_map import spherical_conformal_map
from ....mesh.check import check_mesh
from ....sphere.rows import unit_rows
from ...viewer import SUBJECTS, UPS, ResultView, add_picture_arguments, guess_up, open_for, run_app
from ..exits import Exit
from ..pair import load_pair
from ..source import Source, add_source, load_source

FloatArray = NDArray[np.float64]
#: What colours can show, by the words that users give.
_SHOWN = dict(zip(("foldings", "factor", "angles"), SUBJECTS, strict=True))


def configure(parser: ArgumentParser) -> None:
    """Add the arguments."""
    add_source(parser)
    parser.add_argument(
        "sphere", metavar="SPHERE", nargs="?", help="its map, if there is one; else it is made, or found in an .npz"
    )
    parser.add_argument("--method", choices=tuple(METHODS), default="auto", help="that makes the map; default: auto")
    parser.add_argument("--show", choices=tuple(_SHOWN), default="foldings", help="by colours; default: foldings")
    parser.add_argument("--up", choices=tuple(UPS), help="which way is up; default: z, but y for .obj, .glb, .gltf")
    add_picture_arguments(parser)


def run(args: Namespace) -> Exit:
    """Show the map, whether it folds or not."""
    open_for(args, "igl_spheremap")
    source, x, caption = _map(args)
    args.progress.close()
    mesh = check_mesh(source.v, source.f)
    up = args.up or guess_up(source.name)
    panel = not (args.screenshot or args.video)
    run_app(ResultView(mesh, x, caption, up=up, subject=_SHOWN[args.show], panel=panel), args)
    return Exit.OK


def _map(args: Namespace) -> tuple[Source, FloatArray, str]:
    """The mesh, its map, and a caption."""
    if args.sphere is not None:
        source, name, x = load_pair(args)
        bad = np.flatnonzero(~(np.linalg.norm(x, axis=1) > 0) | ~np.isfinite(x).all(axis=1))
        if len(bad):
            raise MeshError(f"{name}: vertex {bad[0]} is at the origin or not finite; give a map to a sphere")
        return source, unit_rows(x), Path(name).name
    source = load_source(args)
    if source.name.endswith(".npz") and not args.repair:
        try:
            return source, read_map(source.name).sphere, "map"
        except MeshError:  # the archive holds a mesh only
            pass
    args.progress.stage(f"mapping {source.name}")
    result = spherical_conformal_map(source.v, source.f, args.method, listener=args.progress.listener(source.f))
    return source, result.sphere, f"map ({args.method})"
