"""Watch a map being computed step by step, in a window, as a picture or as a video.

    igl-spheremap play sample:dino
    igl-spheremap play lh.pial --method auto
    igl-spheremap play bunny.ply --video bunny.gif --json bunny_frames.json
    igl-spheremap play sample:dino --screenshot dino.png
"""

from __future__ import annotations

from argparse import Namespace
from functools import partial

from ....mesh.arrays import FloatArray, IntArray
from ...viewer.app import open_for, run_app
from ...viewer.choices import guess_up
from ...viewer.player import Player, PlayerWindow
from ..chosen import chosen_method
from ..output import Findings
from ..source import Source, load_source, read_source
from ..streams import check_outputs


def run(args: Namespace) -> None:
    """Play the run, whether its map folds or not."""
    check_outputs(args)
    method = chosen_method(args)
    open_for(args, "igl_spheremap")
    source = load_source(args)
    args.progress.stage(f"mapping {source.name}")
    load = partial(_load, source)
    up = args.up or guess_up(source.name)
    pictures = bool(args.screenshot or args.video)
    kind = Player if pictures else PlayerWindow
    frames = run_app(kind(load, source.name, method, up=up, size=tuple(args.size)), args)
    if pictures:
        found = Findings(source=source.name, method=args.method, frames=frames)
        for k, frame in enumerate(frames):
            found.add(f"picture {k}", f"{frame['title']}: {frame['foldings']} folded")
        found.report(args)


def _load(given: Source, name: str) -> tuple[FloatArray, IntArray]:
    """Vertices and faces by name, in any process; those of the command line are read already."""
    source = given if name == given.name else read_source(name)
    return source.v, source.f
