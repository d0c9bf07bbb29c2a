"""Show a surface beside its sphere, in a window or as a picture.

    igl-spheremap view sample:dino
    igl-spheremap view lh.pial lh.sphere.conformal --show angles
    igl-spheremap view bunny_map.npz --screenshot bunny.png
"""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from ....errors import FoldingsRemain, MeshError
from ....io import read_map
from ....maps.balanced import rebalance
from ....maps.spherical_conformal_map import spherical_conformal_map
from ....mesh.check import check_mesh
from ....result.sphere_map import SphereMap
from ...viewer.app import open_for, run_app
from ...viewer.choices import SHOWN, guess_up
from ...viewer.result_view import ResultView, caption_of
from ..pair import load_pair
from ..source import Source, load_source


def run(args: Namespace) -> None:
    """Show the map, whether it folds or not."""
    open_for(args, "igl_spheremap")
    source, result, caption = _map(args)
    args.progress.close()
    mesh = check_mesh(source.v, source.f)
    up = args.up or guess_up(source.name)
    panel = not (args.screenshot or args.video)
    view = ResultView(mesh, result.sphere, caption, up=up, subject=SHOWN[args.show], panel=panel, result=result)
    run_app(view, args)


def _map(args: Namespace) -> tuple[Source, SphereMap, str]:
    """The mesh, its map, and a caption."""
    if args.sphere is not None:
        pair = load_pair(args)
        try:
            result = pair.map()
        except FoldingsRemain as error:
            result = error.result
        return pair.source, result, Path(pair.name).name
    source = load_source(args)
    if source.name.endswith(".npz") and not args.repair:
        try:
            return source, read_map(source.name), "map"
        except MeshError:  # the archive holds a mesh only
            pass
    args.progress.stage(f"mapping {source.name}")
    listener = args.progress.listener(source.f)
    result = spherical_conformal_map(source.v, source.f, args.method, listener=listener)
    if args.balance:
        result = rebalance(result, args.balance, listener=listener)
    return source, result, caption_of(result)
