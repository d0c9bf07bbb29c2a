"""The table of commands with their arguments, and the parser that is made from it.

Nothing here takes time to import: a wrong line is refused at once. The work of a command is a function `run_...`
of a module in `commands/`, whose docstring is the help: a sentence, and examples.
"""

import re
import sys
from argparse import Action, ArgumentParser, Namespace, RawDescriptionHelpFormatter
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from inspect import cleandoc
from pathlib import Path
from typing import Any, NoReturn

from ... import samples
from ..._version import __version__
from ...balance import AREA_PRESERVING, CONFORMAL, IN_PLANE
from ...io.formats import CONVENTIONS, FORMATS
from ...shapes.correspondence import STAGES, STIFFNESS, USUAL
from ...shapes.harmonics import LARGEST_DEGREE
from ..reproduce.items import ALL, ITEMS
from ..viewer.choices import CARRIED, CARRIED_SIZE, KEEP, SHOWN
from . import arguments as shared
from .arguments import (
    COUNT,
    FROM_ZERO,
    POSITIVE,
    POSITIVE_COUNT,
    Argument,
    argument,
    check_companions,
    choice,
    goes_with,
    number,
    switch,
)
from .exits import UsageError, status_help

#: A function of a command, and its docstring.
_DOCSTRING = re.compile(r'^def (run_\w+)\(.*?"""(.*?)"""', re.DOTALL | re.MULTILINE)
#: What shows a map between surfaces.
_SHOWING = ("--show", "--screenshot", "--video")


@dataclass(frozen=True)
class Command:
    """A command by the name that is typed, the module of its work, and its arguments."""

    name: str
    module: str
    arguments: tuple[Argument, ...]

    @property
    def _function(self) -> str:
        return f"run_{self.name.replace('-', '_')}"

    @property
    def run(self) -> Callable[..., Any]:
        """The command's work, imported now: help needs none of it."""
        function: Callable[..., Any] = getattr(
            import_module(f"{__package__}.commands.{self.module}"), self._function
        )
        return function

    @property
    def docstring(self) -> str:
        """What the command does in a sentence, and examples."""
        return _docstrings(self.module)[self._function]

    @property
    def examples(self) -> list[str]:
        """Command lines."""
        return self.docstring.split("\n")[2:]


@cache
def _docstrings(module: str) -> dict[str, str]:
    """The docstrings of a module's functions, from its text: to parse all modules took a fourth of the time of help."""
    source = Path(__file__).with_name("commands") / f"{module}.py"
    return {
        name: cleandoc(docstring)
        for name, docstring in _DOCSTRING.findall(source.read_text(encoding="utf-8"))
    }


def _degree(least: int) -> Argument:
    """The degree of an expansion."""
    allowed = number(
        f"from {least} to {LARGEST_DEGREE}", lambda n: least <= n <= LARGEST_DEGREE, int
    )
    return argument("--degree", "L", "the largest degree of harmonics", type=allowed, default=15)


COMMANDS = (
    Command(
        "map",
        "map",
        (
            *shared.source(),
            *shared.target(
                "the sphere, same vertex order (but .stl); .npz holds the whole result; - for stdout"
            ),
            shared.method("auto"),
            *shared.METHOD_OPTIONS,
            shared.balance(CONFORMAL),
            argument(
                "--radius",
                "R",
                "of the sphere in OUT; without it 100 for GIFTI and FreeSurfer, 1 elsewhere",
                type=POSITIVE,
            ),
            switch(
                "--with-surface",
                help="write the surface with the sphere beside it: x y z px py pz of a .ply file",
            ),
            shared.REPORT,
            goes_with("--report", shared.UP),
            argument(
                "--plot", "FILE", "draw energy, foldings and angle differences: .png, .svg or .pdf"
            ),
            *shared.OUTPUT,
        ),
    ),
    Command(
        "check",
        "check",
        (
            *shared.pair(optional=True),
            switch(
                "--directions",
                help="certify the directions of the vertices, whatever their distances",
            ),
            shared.REFLECT,
            *shared.OUTPUT,
        ),
    ),
    Command("disk", "plane", (*shared.PLANE, shared.balance(CONFORMAL))),
    Command("flatten", "plane", (*shared.PLANE, shared.balance(IN_PLANE))),
    Command("info", "info", (*shared.source(), shared.PARTS, *shared.OUTPUT)),
    Command(
        "view",
        "view",
        (
            *shared.source(),
            argument(
                "sphere", "SPHERE", "its map; without it it is made, or found in an .npz", nargs="?"
            ),
            shared.method("auto"),
            shared.balance(CONFORMAL),
            choice("--show", SHOWN, "what the colours show", default="foldings"),
            *shared.pictures(),
            *shared.OUTPUT,
        ),
    ),
    Command(
        "play",
        "view",
        (
            *shared.source(nargs="?", default="sample:dino"),
            shared.method("lai2014"),
            *shared.ENDS,
            argument("--rounds", "N", "the most rounds of Algorithm 2", type=COUNT),
            argument(
                "--keep",
                "MB",
                "megabytes of iterations to keep; of a run that takes more, starts, ends and changes "
                "of foldings stay",
                type=POSITIVE,
                default=KEEP,
            ),
            *shared.pictures(),
            *shared.OUTPUT,
        ),
    ),
    Command(
        "repair",
        "check",
        (
            *shared.pair(),
            *shared.target(
                "the repaired map, same vertex order (but .stl) and radius; - for stdout"
            ),
            *shared.OUTPUT,
        ),
    ),
    Command(
        "resample",
        "transfer",
        (
            *shared.pair("IN"),
            *shared.target("the resampled surface; - for stdout"),
            shared.TO,
            shared.REFLECT,
            *shared.OUTPUT,
        ),
    ),
    Command(
        "transfer",
        "transfer",
        (
            *shared.pair(),
            *shared.target("the data at the vertices of --to, in a format of --data"),
            argument("--data", "FILE", shared.DATA_HELP, required=True),
            shared.TO,
            switch(
                "--labels",
                help="take the value of the vertex with the largest weight, no weighted sum",
            ),
            choice(
                "--method",
                ("linear", "adaptive-area"),
                "adaptive-area keeps integrals, as HCP's ADAP_BARY_AREA",
                default="linear",
            ),
            argument(
                "--matrix",
                "FILE",
                "write the weights by scipy.sparse.save_npz, for values @ matrix",
            ),
            shared.REFLECT,
            *shared.OUTPUT,
        ),
    ),
    Command(
        "export",
        "export",
        (
            *shared.pair(optional=True),
            *shared.target(
                "texture: .glb or .obj (with .mtl and .png); scalar map: .ply, .glb (colours), or a format of "
                "--data of `transfer`"
            ),
            choice(
                "--show",
                ("octahedral", "equirectangular", "factor", "angles"),
                "a texture by one of two projections, "
                "octahedral without --show; or a scalar map: u of the conformal factor e^2u, or mean angle differences "
                "at the vertices in degrees",
            ),
            choice(
                "--texture",
                ("carried", "baked"),
                "SOURCE's own texture: on the map's image, or drawn anew for the "
                "coordinates of --show or of a map to the plane",
            ),
            argument("--image", "FILE", "the picture of a texture; without it a checkerboard"),
            shared.UP,
            *shared.OUTPUT,
        ),
    ),
    Command(
        "harmonics",
        "harmonics",
        (
            *shared.pair("SURFACE"),
            *shared.target(
                ".coef as SPHARM-PDM writes it, or .npz; of many surfaces, "
                "SPHERE being such as spheres/{stem}.ply, one .tsv, .csv or .npz table"
            ),
            _degree(0),
            shared.DATA,
            switch("--align", help="put shapes into the frames of their first-order ellipsoids"),
            argument(
                "--modes",
                "K",
                "of many surfaces: principal components, whose scores come first",
                type=POSITIVE_COUNT,
            ),
            goes_with(
                "--align",
                argument("--template", "FILE", "an aligned shape, which directs the axes"),
            ),
            argument(
                "--surface",
                "FILE",
                "write the surface that the coefficients describe, on the mesh of --to",
            ),
            goes_with("--surface", shared.TO),
            argument("--table", "FILE", "write error and power by degree: .tsv or .csv"),
            *shared.OUTPUT,
        ),
    ),
    Command(
        "grid",
        "harmonics",
        (
            *shared.pair("SURFACE"),
            *shared.target("a picture (.png), or the numbers (.npz, array `grid`, or .npy)"),
            shared.DATA,
            choice(
                "--kind",
                ("equirectangular", "equiangular", "gauss", "octahedral"),
                "cell centres of a picture; equal "
                "steps from pole to pole; Gauss-Legendre latitudes; or the square of which `mesh` makes a mesh again",
                default="equirectangular",
            ),
            argument(
                "--rows",
                "N",
                "rows; without it 180, of the octahedral square 181",
                type=POSITIVE_COUNT,
            ),
            argument(
                "--columns",
                "N",
                "columns; without it twice the rows, of the square as many",
                type=POSITIVE_COUNT,
            ),
            *shared.OUTPUT,
        ),
    ),
    Command(
        "mesh",
        "harmonics",
        (
            argument(
                "image",
                "IMAGE",
                "positions that `grid --kind octahedral` wrote: .npz (array `grid`) or .npy",
            ),
            *shared.target("the mesh"),
            *shared.OUTPUT,
        ),
    ),
    Command(
        "register",
        "register",
        (
            *shared.pair(),
            argument("other", "TARGET", "the surface to lay it on"),
            argument("other_sphere", "TARGET_SPHERE", "its map"),
            *shared.target("SOURCE's map in the frame of TARGET; - for stdout"),
            shared.FEATURE,
            argument(
                "--stages", "LIST", f"which of {', '.join(STAGES)} to run", default=",".join(USUAL)
            ),
            argument(
                "--stiffness",
                "S",
                "weight of the strains beside the features' differences",
                type=POSITIVE,
                default=STIFFNESS,
            ),
            switch(
                "--reflect",
                help="register the mirror image of SOURCE (x to -x); OUT fits SOURCE as it is",
            ),
            switch(
                "--show",
                help="open a window with both spheres, before and after, coloured by the first feature",
            ),
            argument("--screenshot", "OUT.png", "write that as a picture; needs no display"),
            *shared.OUTPUT,
        ),
    ),
    Command(
        "match",
        "match",
        (
            *shared.source("SOURCE"),
            argument(
                "other",
                "TARGET",
                "the surface to map it to; the map in an .npz is kept, others are mapped at "
                "balance 1",
            ),
            *shared.target(
                "TARGET's positions on the connectivity of SOURCE; .npz holds the whole map; - for stdout"
            ),
            argument(
                "--landmarks",
                ("SOURCE", "TARGET"),
                "corresponding vertices, which are met exactly: .pinned or .vts lists",
                nargs=2,
            ),
            shared.several(
                "--curve",
                ("SOURCE", "TARGET"),
                "corresponding curves, such lists of neighbouring vertices, "
                "which meet at the same share of their lengths",
                nargs=2,
            ),
            switch("--soft", help="come near the landmarks, if they can't be met"),
            shared.FEATURE,
            argument(
                "--feature-weight",
                "W",
                "of the features' squared differences beside the strain",
                type=FROM_ZERO,
                default=0.4,
            ),
            switch("--reflect", help="match the mirror image of SOURCE (x to -x); OUT has it, too"),
            argument(
                "--overlay",
                ("ON_SOURCE", "ON_TARGET"),
                "write the common refinement with its positions on each",
                nargs=2,
            ),
            goes_with(
                _SHOWING,
                choice("--colours", CARRIED, "what pictures show on both", default=CARRIED[0]),
            ),
            switch("--show", help="open a window with both and what is between them"),
            *(
                goes_with(_SHOWING, each) if each[0][0] in ("--up", "--size") else each
                for each in shared.pictures(CARRIED_SIZE)
            ),
            *shared.OUTPUT,
        ),
    ),
    Command(
        "template",
        "template",
        (
            shared.SOURCES,
            argument(
                "--out",
                "DIR",
                "folder of the group: archive, mean surface, table, page and the members' maps",
                required=True,
            ),
            switch(
                "--series", help="follow points of one body, whose frames IN are in their order"
            ),
            shared.several(
                "--feature",
                "NAME=PATTERN",
                "data over the vertices of each IN, as "
                "{folder}/{stem}.thickness or {folder}/{stem}.npz:NAME",
            ),
            argument("--modes", "K", "how many principal modes", type=POSITIVE_COUNT, default=10),
            argument(
                "--to",
                "ico:K",
                "the mean's mesh, of 10 * 4^K + 2 vertices; cortices need ico:5",
                default="ico:4",
            ),
            shared.balance(AREA_PRESERVING),
            switch("--rigid", help="keep the members' sizes; without it shapes are compared"),
            shared.several("--exclude", "IN", "leave this one of the surfaces out"),
            shared.RATINGS,
            *shared.ENGINE,
            argument(
                "--add",
                "NEW",
                "place these surfaces into the group in DIR, which stays as it is",
                nargs="+",
                default=[],
            ),
            argument(
                "--design",
                "TABLE",
                "test what depends on each column of this .tsv or .csv table beside the others; "
                "the first one names the members of the group in DIR",
            ),
            argument(
                "--of",
                "DATA",
                "what is tested: shapes, scores, or a feature of the group",
                default="shapes",
            ),
            argument("--permutations", "N", "of a test", type=POSITIVE_COUNT, default=1000),
            switch(
                "--augment",
                help="test with permuted copies of the covariates: for few members and skewed data",
            ),
            switch("-f", "--force", help="replace the group in DIR"),
            *shared.OUTPUT,
        ),
    ),
    Command(
        "batch",
        "batch",
        (
            shared.SOURCES,
            shared.PARTS,
            argument(
                "--out",
                "PATTERN",
                "where each sphere goes: {folder}, {name} and {stem} are those of IN, such as "
                "{folder}/lh.sphere.conformal or spheres/{stem}.ply",
                required=True,
            ),
            shared.method("auto"),
            *shared.METHOD_OPTIONS,
            shared.balance(CONFORMAL),
            *shared.MANY,
            *shared.READING[1:],
        ),
    ),
    Command(
        "sphere-reg",
        "sphere_reg",
        (
            shared.SOURCES,
            shared.several(
                "--to",
                "TEMPLATE",
                "fsaverage (without --to), fsaverage3 to fsaverage7 or fsLR, from programs "
                "on this machine; or NAME=SURFACE,SPHERE",
                dest="templates",
            ),
            argument(
                "--out",
                "DIR",
                "the folder for the files; {folder} is that of IN, {subject} its subject",
                required=True,
            ),
            shared.several(
                "--names",
                "CONVENTION",
                f"by whose files are named: {', '.join(CONVENTIONS)}; without it bids",
                choices=CONVENTIONS,
            ),
            shared.several(
                "--labels",
                "FILE",
                "labels on a template, .annot or .label.gii, to be carried to the "
                "surfaces; {hemi} is lh or rh, {side} L or R",
            ),
            switch(
                "--reflect",
                help="register mirror images (x to -x) to the templates of the other side",
            ),
            choice("--hemi", ("L", "R"), "the side, where neither the name nor the file tells it"),
            *shared.MANY,
        ),
    ),
    Command(
        "spharm-pdm",
        "spharm_pdm",
        (
            shared.SOURCES,
            argument(
                "--out",
                "DIR",
                "the folder for X_surf.vtk, X_para.vtk (the map), X_surf_SPHARM and its ellalign; "
                "{folder} is that of IN",
                required=True,
            ),
            _degree(1),
            argument(
                "--subdivision",
                "N",
                "parts of the icosahedron's edges: 10 N^2 + 2 points",
                type=number("from 1 to 1000", lambda n: 1 <= n <= 1000, int),
                default=10,
            ),
            argument(
                "--template",
                "FILE",
                "an ellalign.coef that directs each body's axes; without it their own third "
                "moments",
            ),
            shared.balance(AREA_PRESERVING),
            *shared.MANY,
        ),
    ),
    Command(
        "reproduce",
        "reproduce",
        (
            argument(
                "names",
                "WHAT",
                f"{', '.join(ITEMS)}, or {ALL}: four minutes",
                nargs="+",
                choices=(*ITEMS, ALL),
            ),
            argument(
                "--meshes",
                "DIR",
                "counterparts of the paper's surfaces (docs/corpus.md); without it samples stand "
                "in",
                type=Path,
            ),
            argument(
                "--out",
                "DIR",
                "where results and finished runs are kept; run again to continue",
                type=Path,
                default=Path("reproduction"),
            ),
            argument(
                "--max-iterations",
                "N",
                "of each minimisation; without it the methods' own",
                type=COUNT,
            ),
            switch("-q", "--quiet", help="print nothing"),
        ),
    ),
)

#: What the commands are about, in the order in which help lists them; those of `SHAPES` call `igl_spheremap.shapes`.
SHAPES = "several surfaces, and harmonics (ism.shapes)"
GROUPS = {
    "a map and its certificate": ("map", "check", "repair", "view"),
    "the paper": ("play", "reproduce"),
    "surfaces, and what is done with a map": ("info", "export", "transfer", "resample"),
    "surfaces with a boundary, in the plane": ("disk", "flatten"),
    SHAPES: (
        "match",
        "register",
        "sphere-reg",
        "template",
        "harmonics",
        "grid",
        "mesh",
        "spharm-pdm",
    ),
    "many files": ("batch",),
}


class _ByGroup(RawDescriptionHelpFormatter):
    """Help that lists the commands under what they are about."""

    def _format_action(self, action: Action) -> str:
        lines_of = super()._format_action
        if action.dest != "command":
            return lines_of(action)
        rows = {row.dest: row for row in action._get_subactions()}  # type: ignore[attr-defined]
        lines = []
        for title, names in GROUPS.items():
            lines += [f"\n  {title}:\n", *(f"  {lines_of(rows[name])}" for name in names)]
        return "".join(lines)


def _near(word: str, names: list[str]) -> list[str]:
    """The name that may have been meant by a word, if there is one."""
    from difflib import get_close_matches  # only wrong lines need it

    return get_close_matches(word, names, n=1)


class _Parser(ArgumentParser):
    """A parser that raises what goes wrong: wrong usage, and help that its stream can't take."""

    def error(self, message: str) -> NoReturn:
        raise UsageError(f"{message} (see {self.prog} --help)")

    def parse(self, words: list[str]) -> Namespace:
        """Parse a command line; a UsageError names what may have been meant by an unknown command or flag."""
        first, names = words[0], [command.name for command in COMMANDS]
        if first not in names and not first.startswith("-"):
            near = _near(first, names)
            meant = near or ([f"map {first} OUT"] if "." in first or ":" in first else [])
            raise UsageError(
                f"there is no command {first!r}"
                + "".join(f"; did you mean {one}?" for one in meant)
                + f" (see {self.prog} --help)"
            )
        if "" in words:  # as a path it would be the working folder
            raise UsageError(
                f"argument {words.index('')} of {first} is empty: a variable of the shell may be unset"
            )
        args, unknown = self.parse_known_args(words)
        if unknown:
            flags = [
                flag for names, _ in args.row.arguments for flag in names if flag.startswith("--")
            ]
            near = _near(unknown[0].partition("=")[0], flags)
            raise UsageError(
                f"{args.command} takes no {unknown[0]}"
                + "".join(f"; did you mean {one}?" for one in near)
                + f" (see {self.prog} {args.command} --help)"
            )
        check_companions(args)
        return args

    # argparse's own hides OSErrors
    def _print_message(self, message: str, file: Any = None) -> None:
        (file or sys.stderr).write(message)


def build_parser(words: Collection[str] | None = None) -> _Parser:
    """The parser of the command line; with its words, commands not among them get no arguments, which takes time."""
    suffixes = " ".join(
        suffix for entry in FORMATS if entry.name != "FreeSurfer" for suffix in entry.suffixes
    )
    firsts = [
        command for first, *_ in GROUPS.values() for command in COMMANDS if command.name == first
    ]
    parser = _Parser(
        prog="igl-spheremap",
        description="Conformal maps of genus-0 meshes to the unit sphere, proved free of foldings.",
        epilog=f"{_examples(command.examples[0] for command in firsts)}\nfiles:\n"
        f"  {suffixes} and FreeSurfer's (lh.pial, lh.sphere.conformal);\n"
        "  sample:NAME[:key=value,...] is a shape that the package makes itself, NAME one of\n"
        f"  {', '.join(samples.names())}\n\n{status_help()}",
        formatter_class=_ByGroup,
    )
    parser.add_argument("--version", action="version", version=f"igl-spheremap {__version__}")
    subparsers = parser.add_subparsers(
        title="commands", dest="command", metavar="COMMAND", required=True, parser_class=_Parser
    )
    for command in COMMANDS:
        purpose = command.docstring.partition("\n")[0]
        subparser = subparsers.add_parser(
            command.name,
            help=purpose[0].lower() + purpose[1:].rstrip("."),
            description=purpose,
            epilog=f"{_examples(command.examples)}\n{status_help()}",
            formatter_class=RawDescriptionHelpFormatter,
        )
        for names, options in command.arguments if words is None or command.name in words else ():
            subparser.add_argument(
                *names, **{name: value for name, value in options.items() if name != "goes_with"}
            )
        subparser.set_defaults(row=command)
    return parser


def _examples(lines: Iterable[str]) -> str:
    return "examples:\n" + "".join(f"  {line}\n" for line in lines)
