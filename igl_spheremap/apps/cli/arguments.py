"""The arguments that several commands share, each described once; nothing here takes time to import."""

import math
from argparse import ArgumentTypeError, BooleanOptionalAction, Namespace
from collections.abc import Callable, Iterable
from dataclasses import fields
from typing import Any, get_args

from ...io.formats import FORMATS
from ...maps.options import METHODS, Gauge, Polish
from ...mesh_repair import LARGEST_WELD
from ...paper.settings import EdgeWeights, Lai2014, PaperGauge, PaperMetric
from ...result.method import Method
from ..viewer.choices import LENGTH, RATE, SIZE, UPS
from .exits import UsageError

#: Arguments of `ArgumentParser.add_argument`.
Argument = tuple[tuple[str, ...], dict[str, Any]]

_FORMATS = [entry.suffixes[0].removeprefix(".") for entry in FORMATS]
WRITTEN = ("obj", "off")  # on stdout: text, nothing that would garble a terminal


def number(
    kind: type[float], least: float, most: float = math.inf, *, above: bool = False
) -> Callable[[str], Any]:
    """A type of arguments for argparse: numbers from the least on, or only `above` it, up to the most.

    >>> number(int, 0)("7")
    7
    """
    words = f"number from {least:g}"
    if above:
        words = f"number above {least:g}"
    elif math.isfinite(most):
        words += f" to {most:g}"
    if kind is int:
        words = f"whole {words}"

    def parse(text: str) -> float:
        value = kind(text)
        within = least <= value <= most and math.isfinite(value)
        if not within or (above and value == least):
            raise ArgumentTypeError(f"{text} is out of range: give a {words}")
        return value

    parse.__name__ = "number"  # argparse: "invalid number value: 'x'"
    return parse


COUNT = number(int, 0)
POSITIVE_COUNT = number(int, 1)
FROM_ZERO = number(float, 0)
POSITIVE = number(float, 0, above=True)
FROM_0_TO_1 = number(float, 0, 1)
#: Pixels that the panels need, and those that OpenGL draws everywhere.
_SIDE = number(int, 200, 8192)


def cut(text: str) -> int | list[int] | str:
    """Parse --cut: a number of tips, vertices with commas between them, or the file of a list of vertices."""
    if text.isdigit():
        return int(text)
    words = text.split(",")
    if all(word.isdigit() for word in words):
        return [int(word) for word in words]
    return text


def rim(text: str) -> int | list[float]:
    """Parse --rim: the number of a vertex, or a point of three coordinates."""
    try:
        words = text.split(",")
        if len(words) == 1:
            return int(text)
        if len(words) == 3:
            return [float(word) for word in words]
    except ValueError:
        pass
    raise ArgumentTypeError(f"{text!r}: give a vertex such as 17, or a point such as 0,0,-50")


def argument(
    name: str,
    metavar: str | tuple[str, ...] | None,
    help: str,
    type: Callable[[str], Any] | None = None,
    default: object = None,
    **options: Any,
) -> Argument:
    """A positional argument, or a flag with a value, whose default the help says."""
    if default not in (None, []):
        help += "; default: %(default)s"
    return (name,), {"metavar": metavar, "help": help, "type": type, "default": default, **options}


def choice(name: str, choices: Iterable[str], help: str, default: str | None = None) -> Argument:
    """A flag whose value is one of a list."""
    return argument(name, None, help, default=default, choices=tuple(choices))


def several(name: str, metavar: str | tuple[str, ...], help: str, **options: Any) -> Argument:
    """A flag with a value that may be given again."""
    return argument(
        name, metavar, f"{help}; may be given again", action="append", default=[], **options
    )


def switch(name: str, help: str, *short: str) -> Argument:
    """A flag without a value, and perhaps its short form."""
    return (*short, name), {"action": "store_true", "help": help}


def goes_with(flags: str, argument: Argument) -> Argument:
    """Make a flag depend on others, with commas between them: unless one of them is given, it is refused."""
    names, options = argument
    return names, options | {"goes_with": tuple(flags.split(", "))}


def is_given(args: Namespace, argument: Argument) -> bool:
    """Whether an argument has another value than its default."""
    names, options = argument
    place = options.get("dest", names[-1].lstrip("-").replace("-", "_"))
    if options.get("action") == "store_true":
        return bool(getattr(args, place))
    return bool(getattr(args, place) != options.get("default"))


def check_companions(args: Namespace) -> None:
    """Raise a UsageError for a flag that is given without one that it goes with."""
    for flag in args.row.arguments:
        wanted = flag[1].get("goes_with", ())
        there = [other for other in args.row.arguments if set(other[0]) & set(wanted)]
        if there and is_given(args, flag) and not any(is_given(args, other) for other in there):
            words = ", ".join(wanted[:-1]), wanted[-1]
            raise UsageError(f"{flag[0][-1]} goes with {' or '.join(filter(None, words))}")


def refuse_flags(args: Namespace, names: Iterable[str], why: str) -> None:
    """Raise a UsageError for given flags of these names; `why` says what ignores them."""
    found = [
        flag[0][-1] for flag in args.row.arguments if flag[0][-1] in names and is_given(args, flag)
    ]
    if found:
        raise UsageError(f"{why} takes no {' and no '.join(found)}")


def source(name: str = "IN", **options: Any) -> tuple[Argument, ...]:
    """Make the arguments for a mesh: its file, called `name` in the help text, and the flags for reading it."""
    return argument(
        "source", name, "a mesh file, sample:NAME[:key=value,...], or - for stdin", **options
    ), *READING


def pair(name: str = "SOURCE", optional: bool = False) -> tuple[Argument, ...]:
    """Make the arguments for a mesh and its map, which may be left out if `optional`."""
    help = "its map: the same faces, vertices on a sphere about the origin; - for stdin"
    if not optional:
        return *source(name), argument("sphere", "SPHERE", help)
    help += (
        f"; or a map to the plane; may be left out where {name} is an .npz that holds the map, or an .obj "
        "with texture coordinates"
    )
    return *source(name), argument("sphere", "SPHERE", help, nargs="?")


def target(help: str) -> tuple[Argument, ...]:
    """OUT, and the flag that allows to replace it."""
    return argument("target", "OUT", help), switch("--force", "replace OUT if it exists", "-f")


def method(default: str) -> Argument:
    """The choice of a method."""
    return choice("--method", METHODS, "the method of the map", default)


def balance(default: float) -> Argument:
    """The balance of a map."""
    return argument(
        "--balance",
        "T",
        "between 0, conformal, and 1, area-preserving",
        FROM_0_TO_1,
        default,
    )


def pictures(size: tuple[int, int] = SIZE, shown_by: str | None = None) -> tuple[Argument, ...]:
    """Make the arguments of commands that draw; `size` is the default of --size.

    If pictures are shown by certain flags only, --up and --size go with these.
    """
    shown: tuple[Argument, ...] = (
        UP,
        argument(
            "--size",
            ("WIDTH", "HEIGHT"),
            "of the window or picture, pixels",
            _SIDE,
            size,
            nargs=2,
        ),
    )
    if shown_by is not None:
        shown = tuple(goes_with(shown_by, each) for each in shown)
    return (
        *shown,
        argument("--screenshot", "OUT.png", "write one picture; needs no display"),
        goes_with(
            "--screenshot",
            argument("--frame", "K", "number of the frame, from 0; -1 is the last", int),
        ),
        argument("--video", "OUT", "write OUT.gif, or OUT.mp4 (by ffmpeg); needs no display"),
        goes_with(
            "--video",
            argument("--length", "N", "approximate number of pictures", POSITIVE_COUNT, LENGTH),
        ),
        goes_with(
            "--video",
            argument("--fps", "N", "pictures a second", POSITIVE_COUNT, RATE),
        ),
    )


#: Reading of a mesh.
READING = (
    argument(
        "--format",
        "FMT",
        f"of stdin: %(choices)s; of stdout: {' or '.join(WRITTEN)}",
        choices=_FORMATS,
        default="obj",
    ),
    switch(
        "--repair",
        "weld open edges, triangulate, reorient, remove surplus faces; implied by the next four",
    ),
    argument(
        "--weld",
        "T",
        "weld vertices along open edges up to T diagonals of the bounding box",
        number(float, 0, LARGEST_WELD),
    ),
    switch("--keep-largest", "keep only the largest component"),
    switch("--fill-holes", "close holes by caps"),
    switch("--cut-handles", "cut handles along short loops, and close the cuts by caps"),
)
OUTPUT = (
    argument("--json", "FILE", "write the figures as JSON; '-' is stdout, instead of the summary"),
    switch("--quiet", "print no summary", "-q"),
)
DATA_HELP = (
    "data over the vertices: .gii, CIFTI, .npz, .npy, .csv, .tsv, .txt, .1D, .ply, .vtk, .annot or "
    "FreeSurfer's curvature; FILE:NAME takes one map or column"
)
DATA = argument("--data", "FILE", f"{DATA_HELP}; without it the positions")
FEATURE = several(
    "--feature", "NAME=SOURCE,TARGET", "files of data to compare; without it the shape"
)
TO = argument(
    "--to",
    "MESH",
    "a sphere mesh: ico:K of 10 * 4^K + 2 vertices, fsaverage3 to fsaverage7 or fsLR from "
    "programs on this machine, or a file such as another map",
    default="ico:5",
)
REFLECT = switch(
    "--reflect", "mirror SOURCE and its sphere first (x to -x), as `register --reflect` did"
)
#: Ends of methods, each by its own measure, and the settings of lai2014 beside its default.
ENDS = (
    argument(
        "--tolerance",
        "T",
        "energy above the minimum, in units of the mesh's discretisation error (auto)",
        FROM_ZERO,
    ),
    argument("--gradient-tolerance", "T", "norm of the gradient (lai2014, gu-yau)", FROM_ZERO),
    argument(
        "--max-iterations", "N", "of each minimisation, so of each round of Algorithm 2", COUNT
    ),
    switch(
        "--as-printed",
        "Algorithms 1 and 2 without safeguards (lai2014); other options count on top",
    ),
    switch("--as-programmed", "the rules of the authors' published program (lai2014)"),
)
#: Options of single methods, which name them.
METHOD_OPTIONS = (
    *ENDS,
    choice(
        "--polish",
        (*get_args(Polish), "none"),
        "lower the angle differences of a good map: if that gains "
        "enough (auto), always, or never, as in a batch",
    ),
    choice(
        "--gauge",
        dict.fromkeys((*get_args(Gauge), *get_args(PaperGauge))),
        "place of tips of limbs too deep for "
        "float64 (auto): ends of the axes, or centred and shortened; free: no fixed Moebius gauge (lai2014)",
    ),
    choice(
        "--edge-weights",
        get_args(EdgeWeights),
        "of intrinsic Delaunay triangles, or the paper's (lai2014)",
    ),
    choice("--metric", get_args(PaperMetric), "divisor of the energy's derivatives (lai2014)"),
)
UP = choice(
    "--up",
    UPS,
    "the up direction in pictures and .glb files; without it by the file's name and format, or "
    "its shape",
)
REPORT = argument("--report", "PAGE", "write x.html, or a page in a folder: figures and pictures")
RATINGS = argument("--ratings", "FILE", "leave out surfaces rated fail in this table of a page")
SOURCES = argument(
    "sources", "IN", "mesh files, globs in quotes, or @FILE with one of them a line", nargs="*"
)
PARTS = switch(
    "--parts",
    "take each closed part of a file as a surface of its own: part K of name.obj is "
    "name.obj:K, and its {stem} name_K",
)
#: Workers on many files, and limits of jobs.
ENGINE = (
    argument("--jobs", "N", "processes; without it one for each processor", POSITIVE_COUNT),
    argument(
        "--scheduler",
        "ADDRESS",
        "run on the workers of a Dask scheduler: tcp://HOST:8786, or its file",
    ),
    (
        ("--resume",),
        {
            "help": "keep what the manifest holds of the same file, options and version; default: on",
            "action": BooleanOptionalAction,
            "default": True,
        },
    ),
    switch("--retry-failed", "run failed jobs again"),
    argument("--timeout", "SECONDS", "end a job that takes longer", POSITIVE),
    argument("--retries", "N", "repeats of a job whose process died", COUNT, 1),
)
#: Arguments of all commands that make files of many.
MANY = (
    *ENGINE,
    argument(
        "--manifest",
        "FILE",
        "inputs and results so far, as JSON lines; without it in the folder of all targets",
    ),
    argument("--summary", "FILE", "a table with a line for each file: .tsv or .csv"),
    REPORT,
    switch("--force", "replace any other file at a target", "-f"),
    switch("--quiet", "print nothing", "-q"),
)
#: Arguments of `disk` and `flatten`.
PLANE = (
    *source(),
    goes_with(
        "--fill-holes",
        argument(
            "--rim",
            "VERTEX|X,Y,Z",
            "leave open the hole nearest to this "
            "vertex or point (--rim=-1,0,0); without it the longest",
            rim,
        ),
    ),
    argument(
        "--cut",
        "K|V,V,...|LIST",
        "cut a closed surface open along short paths through K of its tips, these "
        "vertices, or those of a .pinned or .vts list",
        cut,
    ),
    argument("--patch", "FILE", "map the part of IN that this patch of FreeSurfer's holds"),
    goes_with(
        "--patch",
        argument(
            "--via",
            "SPHERE",
            "the patch is a template's: carry its cuts over this sphere, on which IN is registered to it",
        ),
    ),
    goes_with(
        "--via",
        argument(
            "--template",
            "NAME|FILE",
            "the template of the patch, or its sphere",
            default="fsaverage",
        ),
    ),
    goes_with(
        "--via",
        argument(
            "--labels",
            "FILE",
            "labels of IN, .annot or .label.gii: say which areas lie beyond the cuts",
        ),
    ),
    *target(
        ".obj or .glb (the surface with texture coordinates), .npz (both), lh.NAME.patch.flat, or the image as a "
        "mesh"
    ),
    REPORT,
    UP,
    argument(
        "--plot", "FILE", "draw the image and the changes of angles and areas: .png, .svg or .pdf"
    ),
    *OUTPUT,
)


def repair_options(args: Namespace) -> dict[str, Any]:
    """The options of `repair_mesh` that flags stand for."""
    options: dict[str, Any] = {}
    if args.weld is not None:
        options["weld"] = args.weld
    if args.keep_largest:
        options["keep_largest"] = True
    if args.fill_holes:
        options["holes"] = "fill"
    if args.cut_handles:
        options["handles"] = "cut"
    return options


def repair_of(args: Namespace) -> dict[str, Any] | None:
    """The options of --repair, which each of their flags implies; None without any."""
    options = repair_options(args)
    if args.repair or options:
        return options
    return None


def chosen_method(args: Namespace, **defaults: object) -> Method:
    """The method of --method with the options whose flags were given, which it must know.

    `defaults` are the command's own, of options that the method knows.
    """
    known = {name: [option.name for option in fields(record)] for name, record in METHODS.items()}
    names = sorted(set().union(*known.values()))
    options = {name: value for name in names if (value := getattr(args, name, None)) is not None}
    if options.get("polish") == "none":
        options["polish"] = None
    if unknown := set(options) - set(known[args.method]):
        flags = sorted(f"--{name.replace('_', '-')}" for name in unknown)
        raise UsageError(f"--method {args.method} takes no {' and no '.join(flags)}")
    options = {
        name: value for name, value in defaults.items() if name in known[args.method]
    } | options
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
