"""`view` and `play`: a map, or the steps of its run, in a window, as a picture or as a video."""

import os
from argparse import Namespace
from functools import partial
from pathlib import Path

from ....errors import FileError, FoldingsRemain, MeshError
from ....maps.sphere_map import SphereMap
from ....mesh.arrays import FloatArray, IntArray
from ....mesh.disk import check_disk
from ...viewer.app import App, announce, file_stem, open_for, run_app
from ...viewer.choices import SHOWN
from ...viewer.compare import plane_view
from ...viewer.map_view import MapView, caption_of
from ...viewer.player import Player, in_background
from ..arguments import chosen_method, refuse_flags
from ..exits import UsageError
from ..inputs import InputMesh, load_pair, load_source, map_of, read_source, up_of
from ..output import Findings, check_outputs, pictures_of
from .plane import find_plane_map

#: Flags of a map's method.
_MAKING = ("--method", "--balance")


def run_view(args: Namespace) -> None:
    if args.sphere is not None:
        refuse_flags(args, _MAKING, f"{args.sphere}, a map that is there,")
    check_outputs(args)
    pictures = pictures_of(args)
    title = f"{os.path.basename(args.source)} - map"
    open_for(pictures, title=title, said=f"mapping {args.source}")
    app: App
    try:
        source, result, caption = _map(args)
    except (MeshError, UsageError, FileError):
        plane = find_plane_map(args)
        if plane is None:
            raise
        refuse_flags(
            args, (*_MAKING, "--show"), "a map to the plane, which is shown with a checkerboard,"
        )
        source, p = plane
        name = os.path.basename(source.name)
        app = plane_view(name, check_disk(source.v, source.f), p, up_of(args, source))
    else:
        app = MapView(
            result.mesh,
            {caption: result.sphere},
            up=up_of(args, source),
            subject=SHOWN[args.show],
            result=result,
            name=file_stem(source.name, "map"),
        )
    args.progress.close()
    run_app(app, pictures, progress=args.progress)
    if pictures.offscreen:
        found = Findings()
        found.source(source)
        found.written(screenshot=args.screenshot, video=args.video)
        found.report(args)


def _map(args: Namespace) -> tuple[InputMesh, SphereMap, str]:
    """The mesh, its map, and a caption."""
    if args.sphere is not None:
        pair = load_pair(args)
        try:
            result = pair.map()
        except FoldingsRemain as error:
            result = error.result
        return pair.source, result, Path(pair.name).name
    source = load_source(args)
    result = map_of(args, source, balance=args.balance, method=args.method)
    return source, result, caption_of(result)


def run_play(args: Namespace) -> None:
    check_outputs(args)
    method = chosen_method(args)
    pictures = pictures_of(args)
    title = f"{os.path.basename(args.source)} - player"
    open_for(pictures, title=title, said=f"reading {args.source}")
    source = load_source(args)
    announce(pictures, f"mapping {len(source.v):,} vertices")
    args.progress.begin(f"mapping {source.name}")
    load = partial(_load, source)
    start = partial(in_background, load, round(1e6 * args.keep))
    frames = run_app(
        Player(start, source.name, method, up=up_of(args, source), always_up=args.up is not None),
        pictures,
        progress=args.progress,
        listener=args.progress.listener(source.f),
    )
    if pictures.offscreen:
        found = Findings(source=source.name, method=args.method, frames=frames)
        for k, frame in enumerate(frames):
            found.add(f"picture {k}", f"{frame['title']}: {frame['foldings']} folded")
        found.written(screenshot=args.screenshot, video=args.video)
        found.report(args)


def _load(given: InputMesh, name: str) -> tuple[FloatArray, IntArray]:
    """Read vertices and faces by their name, or take those of the command line, which were read already."""
    if name == given.name:
        return given.v, given.f
    source = read_source(name, check=False)
    return source.v, source.f
