"""The arguments that several commands share, each described once; nothing here takes time to import."""

import math
from argparse import ArgumentTypeError, BooleanOptionalAction, Namespace
from collections.abc import Callable, Iterable
from dataclasses import fields
from typing import Any, get_args

from ...io.formats import FORMATS
from ...maps.options import METHODS, Gauge, Polish
from ...mesh import LARGEST_WELD
from ...paper.settings import EdgeWeights, Lai2014, PaperGauge, PaperMetric
from ...result.method import Method
from ...untangle.effort import Effort
from ..viewer.choices import LENGTH, RATE, SIZE, UPS
from .exits import UsageError

#: What `ArgumentParser.add_argument` takes.
Argument = tuple[tuple[str, ...], dict[str, Any]]

_FORMATS = [entry.suffixes[0].removeprefix(".") for entry in FORMATS]
WRITTEN = ("obj", "off")  # on stdout: text, nothing that would garble a terminal


def number(words: str, allowed: Callable[[float], bool], kind: type[float] = float) -> Callable[[str], Any]:
    """A type of arguments for argparse: finite numbers that are allowed, which the words describe.

    >>> number("from 0", lambda n: n >= 0, int)("7")
    7
    """

    def parse(text: str) -> float:
        value = kind(text)
        if not (math.isfinite(value) and allowed(value)):
            raise ArgumentTypeError(f"{text} is out of range: give a {'whole ' * (kind is int)}number {words}")
        return value

    parse.__name__ = "number"  # argparse: "invalid number value: 'x'"
    return parse


COUNT = number("from 0", lambda n: n >= 0, int)
POSITIVE_COUNT = number("from 1", lambda n: n >= 1, int)
FROM_ZERO = number("from 0", lambda n: n >= 0)
POSITIVE = number("above 0", lambda n: n > 0)
FROM_0_TO_1 = number("from 0 to 1", lambda t: 0 <= t <= 1)
#: Pixels that the panels need, and those that OpenGL draws everywhere.
_SIDE = number("from 200 to 8192", lambda n: 200 <= n <= 8192, int)


def effort(text: str) -> Effort:
    """A type of arguments for argparse: what a repair may cost.

    >>> effort("systems=5,holes=0")
    Effort(systems=5, holes=0, least_gain=0.015, polish_gain=0.004)
    """
    try:
        words = dict(part.split("=") for part in text.split(","))
        numbers: dict[str, Any] = {name: float(n) if name.endswith("gain") else int(n) for name, n in words.items()}
        return Effort(**numbers)
    except (TypeError, ValueError):
        raise ArgumentTypeError(f"{text!r}: give numbers from 0 such as systems=5,holes=0,least_gain=0.05") from None


def _cut(text: str) -> int | list[int] | str:
    """Parse --cut: a number of tips, vertices with commas between them, or the file of a list of vertices."""
    if text.isdigit():
        return int(text)
    words = text.split(",")
    return [int(word) for word in words] if all(word.isdigit() for word in words) else text


def _rim(text: str) -> int | list[float]:
    """Parse --rim: the number of a vertex, or a point of three coordinates."""
    try:
        words = text.split(",")
        if len(words) in (1, 3):
            return int(text) if len(words) == 1 else [float(word) for word in words]
    except ValueError:
        pass
    raise ArgumentTypeError(f"{text!r}: give a vertex such as 17, or a point such as 0,0,-50")


def argument(name: str, metavar: str | tuple[str, ...] | None, help: str, **options: Any) -> Argument:
    """A positional argument, or a flag with a value."""
    return (name,), {"metavar": metavar, "help": help, **options}


def choice(name: str, choices: Iterable[str], help: str, **options: Any) -> Argument:
    """A flag whose value is one of a list."""
    return argument(name, None, help, choices=tuple(choices), **options)


def switch(*names: str, help: str, **options: Any) -> Argument:
    """A flag without a value."""
    return names, {"action": "store_true", "help": help, **options}


def goes_with(flags: str | tuple[str, ...], argument: Argument) -> Argument:
    """Make a flag depend on others: it is refused unless one of them is given."""
    names, options = argument
    return names, options | {"goes_with": (flags,) if isinstance(flags, str) else flags}


def is_given(args: Namespace, argument: Argument) -> bool:
    """Whether an argument has another value than its default."""
    names, options = argument
    place = options.get("dest", names[-1].lstrip("-").replace("-", "_"))
    default = options.get("default", False if options.get("action") == "store_true" else None)
    return bool(getattr(args, place) != default)


def check_companions(args: Namespace) -> None:
    """Raise a UsageError for a flag that is given without one that it goes with."""
    for flag in args.row.arguments:
        wanted = flag[1].get("goes_with", ())
        there = [other for other in args.row.arguments if set(other[0]) & set(wanted)]
        if there and is_given(args, flag) and not any(is_given(args, other) for other in there):
            words = ", ".join(wanted[:-1]), wanted[-1]
            raise UsageError(f"{flag[0][-1]} goes with {' or '.join(filter(None, words))}")


def refuse_flags(args: Namespace, names: Iterable[str], why: str) -> None:
    """Raise a UsageError for flags of these names that are given; `why` says what ignores them."""
    found = [flag[0][-1] for flag in args.row.arguments if flag[0][-1] in names and is_given(args, flag)]
    if found:
        raise UsageError(f"{why} takes no {' and no '.join(found)}")


def source(name: str = "IN", **options: Any) -> tuple[Argument, ...]:
    """Make the arguments for a mesh: its file, called `name` in the help text, and the flags for reading it."""
    default = f"; default: {options['default']}" if options else ""
    help = f"a mesh file, sample:NAME[:key=value,...], or - for stdin{default}"
    return argument("source", name, help, **options), FORMAT, *REPAIR


def pair(name: str = "SOURCE", optional: bool = False) -> tuple[Argument, ...]:
    """Make the arguments for a mesh and its map, which may be left out where `optional`."""
    left_out = (f"; or a map to the plane of a surface with a boundary; may be left out where {name} is an .npz that "
                "holds the map, or an .obj with texture coordinates") if optional else ""
    help = "its map: the same faces, vertices on a sphere of any radius about the origin; - for stdin" + left_out
    return *source(name), argument("sphere", "SPHERE", help, nargs="?" if optional else None)


def target(help: str) -> tuple[Argument, ...]:
    """OUT, and the flag that allows to replace it."""
    return argument("target", "OUT", help), switch("-f", "--force", help="replace OUT if it exists")


def method(default: str, help: str) -> Argument:
    """The choice of a method."""
    return choice("--method", METHODS, help, default=default)


def pictures(size: tuple[int, int] = SIZE) -> tuple[Argument, ...]:
    """Make the arguments of commands that draw; `size` is the default of --size."""
    return (
        UP,
        SCREENSHOT,
        goes_with("--screenshot", argument("--frame", "K", "which frame --screenshot shows, from 0; -1 is the last",
                                           type=int)),
        argument("--video", "OUT", "write all frames: OUT.gif, or OUT.mp4 (needs imageio-ffmpeg); "
                 "needs no display"),
        goes_with("--video", argument("--length", "N", "the most pictures of --video, evenly chosen; those at star "
                                      f"maps and repairs are added (default {LENGTH})", type=POSITIVE_COUNT,
                                      default=LENGTH)),
        goes_with("--video", argument("--fps", "N", f"pictures a second of --video (default {RATE})",
                                      type=POSITIVE_COUNT, default=RATE)),
        (("--size",), {"type": _SIDE, "nargs": 2, "default": size, "metavar": ("W", "H"),
                       "help": "of the window in pixels (default {} {})".format(*size)}),
    )


_WELD = number(f"from 0 to {LARGEST_WELD:g}", lambda t: 0 <= t <= LARGEST_WELD)
FORMAT = argument("--format", "FMT", "the format of '-' (stdin for a mesh, stdout for OUT): %(choices)s; of OUT "
                  f"{' or '.join(WRITTEN)}; default: %(default)s", choices=_FORMATS, default="obj")
REPAIR = (
    switch("--repair", help="repair what needs no new geometry: weld open edges, triangulate, reorient, remove "
           "surplus faces"),
    *(goes_with("--repair", each) for each in (
        argument("--weld", "T", "with --repair: weld vertices along open edges up to this distance, a share of the "
                 f"bounding box's diagonal, at most {LARGEST_WELD:g}; default: those at the same place", type=_WELD),
        switch("--keep-largest", help="with --repair: keep only the largest component"),
        switch("--fill-holes", help="with --repair: close holes by caps"),
        switch("--cut-handles", help="with --repair: cut handles along short loops, and close the cuts by caps"),
    )),
)
OUTPUT = (
    argument("--json", "FILE", "write the figures as JSON; '-' is stdout, instead of the summary"),
    switch("-q", "--quiet", help="print no summary"),
)
SILENT = switch("-q", "--quiet", help="print nothing")
SCREENSHOT = argument("--screenshot", "OUT.png", "write one picture; needs no display")
DATA_HELP = ("data over the vertices: .gii, .npz, .npy, .csv, .tsv, .txt, .1D, .ply, .vtk, .annot, or "
             "FreeSurfer's curvature; FILE:NAME takes one map of it, or one column, counted from 0 without a header")
DATA = argument("--data", "FILE", f"{DATA_HELP}; default: the positions")
FEATURE = argument("--feature", "NAME=SOURCE,TARGET", "files with what is compared, as for --data of other commands; "
                   "may be given again; default: curvature and depth of the surfaces", action="append", default=[])
TO = argument("--to", "MESH", "ico:K, an icosahedron subdivided K times: 10 * 4^K + 2 vertices in an order of its "
              "own, not FreeSurfer's, of which the first 10 * 4^J + 2 are ico:J; fsaverage3 to fsaverage7 or fsLR, "
              "in their order, from a file of FreeSurfer, nilearn, neuromaps, TemplateFlow or HCP on this machine; or "
              "a file with a sphere mesh, such as another surface's map; default: ico:5", default="ico:5")
REFLECT = switch("--reflect", help="mirror the surface and its sphere first (x to -x, faces reversed), as `register "
                 "--reflect` did: the other side of a body, in that one's frame")
GRADIENT_TOLERANCE = argument("--gradient-tolerance", "T", "norm of the gradient at which a minimisation ends; "
                              "default: the method's", type=FROM_ZERO)
#: Where methods end, each by what it measures.
TOLERANCES = (
    argument("--tolerance", "T", "energy above the minimum, in units of the mesh's discretisation error (auto)",
             type=FROM_ZERO),
    GRADIENT_TOLERANCE,
)
#: The settings of lai2014 beside its default.
PAPER = (
    switch("--as-printed", help="Algorithms 1 and 2 as the paper prints them, without safeguards (lai2014); other "
           "options count on top"),
    switch("--as-programmed", help="the same by the rules of the authors' published program (lai2014)"),
)
BALANCE = argument("--balance", "T", "between 0, conformal (the default), and 1, area-preserving", type=FROM_0_TO_1,
                   default=0.0)
MAY_FOLD = switch("--may-fold", help="also take steps that fold")
UP = choice("--up", UPS, "which way is up in pictures, or left or right: z is, seen from that side; default: by the "
            "file's name and format, or auto: the way in which the surface stands")
REPORT = argument("--report", "PAGE", "write x.html, or report.html in a folder: figures and pictures")
#: What all commands take that map a mesh and write the map.
MAPPING = (
    *source(),
    *target("the sphere, same vertex order (but .stl); .npz holds the whole result; - for stdout"),
    argument("--max-iterations", "N", "of each minimisation, so of each round of Algorithm 2; default: the method's",
             type=COUNT),
    argument("--radius", "R", "of the sphere in OUT; default: 100 for GIFTI and FreeSurfer, 1 elsewhere",
             type=POSITIVE),
    switch("--with-surface", help="write the surface with the sphere beside it: x y z px py pz of a .ply file"),
    REPORT,
    goes_with("--report", UP),
    argument("--plot", "FILE", "draw energy, foldings and angle differences: .png, .svg or .pdf"),
    switch("--timings", help="print the time of each phase"),
    *OUTPUT,
    switch("-v", "--verbose", help="log every iteration on stderr"),
)
#: What `disk` and `flatten` take.
PLANE = (
    argument("source", "IN", "a mesh file with one boundary loop, or with --cut a closed one, "
             "sample:NAME[:key=value,...], or - for stdin"),
    FORMAT,
    *REPAIR,
    goes_with("--fill-holes", argument("--rim", "VERTEX|X,Y,Z", "with --fill-holes: the hole that stays is the one "
                                       "nearest to this vertex or point (--rim=-1,0,0); default: the longest",
                                       type=_rim)),
    argument("--cut", "K|V,V,...|LIST", "cut a closed surface open along a tree of short paths that joins K of its "
             "tips, these vertices, or those of a .pinned or .vts list", type=_cut),
    argument("--patch", "FILE", "map the part of IN that this patch of FreeSurfer's holds, such as lh.cortex.patch.3d"),
    *target("the map: .obj or .glb (the surface with texture coordinates), .npz (both), lh.NAME.patch.flat, or the "
            "image as a mesh"),
    REPORT,
    UP,
    argument("--plot", "FILE", "draw the image and what happens to angles and areas: .png, .svg or .pdf"),
    *OUTPUT,
)
RATINGS = argument("--ratings", "FILE", "leave out what is rated fail in this table, which a page saved")
#: What all commands take that work on many files.
SOURCES = (
    argument("sources", "IN", "mesh files, globs in quotes, or @FILE with one of them a line", nargs="*"),
    argument("--subjects-dir", "DIR", "take --surface of each subject of a FreeSurfer folder"),
    goes_with("--subjects-dir", argument("--surface", "NAMES", "with --subjects-dir; default: lh.white,rh.white",
                                         default="lh.white,rh.white")),
)
#: What says who works on many files, and when jobs end.
ENGINE = (
    argument("--jobs", "N", "processes; default: one for each processor", type=POSITIVE_COUNT),
    argument("--scheduler", "ADDRESS", "run on the workers of a Dask scheduler: tcp://HOST:8786, or its "
             "scheduler file"),
    (("--resume",), {"help": "keep what the manifest holds of the same file, options and version; default: on",
                     "action": BooleanOptionalAction, "default": True}),
    switch("--retry-failed", help="run again what failed"),
    argument("--timeout", "SECONDS", "end a job that takes longer", type=POSITIVE),
    argument("--retries", "N", "how often a job is run again whose process died (default: 1)", type=COUNT, default=1),
)
MANY = (
    *ENGINE,
    argument("--manifest", "FILE", "inputs and results so far, as JSON lines; default: in the folder of all "
             "targets, or in --subjects-dir"),
    argument("--summary", "FILE", "one line for each file: .tsv, .csv or .jsonl"),
    argument("--report", "PAGE", "write x.html, or index.html in a folder: all results, the worst first"),
    switch("-f", "--force", help="replace any other file at a target"),
    SILENT,
)
#: Options of single methods, which name them.
OPTIONS = (
    *TOLERANCES,
    choice("--polish", (*get_args(Polish), "none"), "lower the angle differences of a good map: where it gains enough "
           "for its cost, always, or never (auto); default: auto, of batch none"),
    choice("--gauge", dict.fromkeys((*get_args(Gauge), *get_args(PaperGauge))), "how limbs too deep for float64 are "
           "kept (auto): poles, the default, takes the deepest tips to ends of the axes, where coordinates are finer; "
           "centred shortens the limbs; and whether the Moebius freedom is held fixed (lai2014): centred, the default, "
           "or free"),
    argument("--effort", "NAME=N,...", "what steps may cost that lower the angle differences after a repair (auto): "
             "systems=20, holes=5, least_gain=0.015 and polish_gain=0.004 are the defaults", type=effort),
    choice("--edge-weights", get_args(EdgeWeights), "those of intrinsic Delaunay triangles, never negative, or the "
           "paper's (lai2014)"),
    choice("--metric", get_args(PaperMetric), "what the energy's derivatives are divided by (lai2014): the laplacian's "
           "rows, areas as the paper has it, or, by vertices, nothing"),
    *PAPER,
)


def given(args: Namespace, *names: str) -> dict[str, Any]:
    """The values of options whose flags were given; without its flag an option has its own default."""
    return {name: value for name in names if (value := getattr(args, name, None)) is not None}


def repair_options(args: Namespace) -> dict[str, Any] | None:
    """The options of `repair_mesh` that flags stand for; None without --repair."""
    if not args.repair:
        return None
    return {"weld": args.weld or 0.0, "keep_largest": args.keep_largest,
            "holes": "fill" if args.fill_holes else "refuse", "handles": "cut" if args.cut_handles else "refuse"}


def chosen_method(args: Namespace, **defaults: object) -> Method:
    """The method of --method with the options whose flags were given, which it must know.

    `defaults` are the command's own, of options that the method knows.
    """
    known = {name: [option.name for option in fields(record)] for name, record in METHODS.items()}
    options = given(args, *sorted(set().union(*known.values())))
    options |= {"polish": None} if options.get("polish") == "none" else {}
    if unknown := set(options) - set(known[args.method]):
        flags = sorted(f"--{name.replace('_', '-')}" for name in unknown)
        raise UsageError(f"--method {args.method} takes no {' and no '.join(flags)}")
    options = {name: value for name, value in defaults.items() if name in known[args.method]} | options
    make = METHODS[args.method]
    for name in ("as_printed", "as_programmed"):
        if getattr(args, name):
            if args.method != Lai2014.name:
                raise UsageError(f"--{name.replace('_', '-')} goes with --method {Lai2014.name}")
            make = getattr(Lai2014, name)
    try:
        return make(**options)
    except ValueError as error:  # choices that only another method knows
        raise UsageError(f"--method {args.method}: {error}") from error
