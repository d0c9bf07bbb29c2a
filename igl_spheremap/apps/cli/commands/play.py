"""`igl-spheremap play IN`: watch a run step by step, in a window, as a picture or as a video."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from dataclasses import dataclass

from ....maps.options import METHODS
from ....mesh.arrays import FloatArray, IntArray
from ...numbers import COUNT, FROM_ZERO
from ...viewer import UPS, add_picture_arguments, guess_up, open_for, run_app
from ...viewer.player import SIZE, Player
from ...viewer.player_window import PlayerWindow, parameters
from ..exits import Exit
from ..failures import UsageError
from ..output import add_output, report, row
from ..source import add_repair, load_source, read_source
from ..streams import add_format, check_outputs

_SOURCE = "sample:dino"


def configure(parser: ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument(
        "source",
        metavar="IN",
        nargs="?",
        default=_SOURCE,
        help=f"a mesh file, sample:NAME[:key=value,...], or - for stdin; default: {_SOURCE}",
    )
    add_format(parser)
    add_repair(parser)
    parser.add_argument("--method", choices=tuple(METHODS), default="lai2014", help="default: lai2014, the paper's")
    parser.add_argument("--tolerance", type=FROM_ZERO, metavar="T", help="of the stopping rule; default: the method's")
    parser.add_argument("--max-iterations", type=COUNT, metavar="N", help="of each round; default: the method's")
    parser.add_argument("--rounds", type=COUNT, metavar="N", help="of Algorithm 2 at the most; default: the method's")
    parser.add_argument("--up", choices=tuple(UPS), help="which way is up; default: z, but y for .obj, .glb, .gltf")
    add_picture_arguments(parser, SIZE)
    add_output(parser)


def run(args: Namespace) -> Exit:
    """Play the run, whether its map folds or not."""
    check_outputs(args)
    given = {name: getattr(args, name) for name in ("tolerance", "max_iterations", "rounds")}
    given = {name: value for name, value in given.items() if value is not None}
    unknown = [f"--{name.replace('_', '-')}" for name in given if name not in parameters(METHODS[args.method]())]
    if unknown:
        raise UsageError(f"--method {args.method} takes no {', '.join(unknown)}")
    method = METHODS[args.method](**given)
    open_for(args, "igl_spheremap")
    source = load_source(args)
    args.progress.stage(f"mapping {source.name}")
    load = _Load(source.name, source.v, source.f)
    up = args.up or guess_up(source.name)
    window = not (args.screenshot or args.video)
    kind = PlayerWindow if window else Player
    player = kind(load, source.name, method, up=up, size=tuple(args.size))
    frames = run_app(player, args)
    if not window:
        summary = [row(f"picture {k}", f"{one['title']}: {one['foldings']} folded") for k, one in enumerate(frames)]
        report(args, {"source": source.name, "method": args.method, "frames": frames}, summary)
    return Exit.OK


@dataclass(frozen=True, eq=False)
class _Load:
    """Vertices and faces by name, in any process; those of the command line are read already."""

    name: str
    v: FloatArray
    f: IntArray

    def __call__(self, name: str) -> tuple[FloatArray, IntArray]:
        if name == self.name:
            return self.v, self.f
        source = read_source(name)
        return source.v, source.f
