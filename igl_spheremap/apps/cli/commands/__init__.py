"""The table of commands and their arguments; nothing here takes time to import, so that help is at once.

The module of its name holds a command's work, `run(args)`, and its docstring is the help.
"""

from __future__ import annotations

import ast
from argparse import BooleanOptionalAction
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from pathlib import Path
from types import ModuleType

from ....shapes.harmonics import LARGEST_DEGREE
from ....shapes.registration import STAGES
from ...reproduce import ALL, ITEMS
from ...viewer.choices import PLAYER_SIZE, SHOWN
from .. import arguments as shared
from ..arguments import COUNT, FROM_ZERO, POSITIVE, POSITIVE_COUNT, Argument, argument, choice, number, switch

_EXPONENT = number("above 1", lambda p: p > 1)
_DEGREE = number(f"from 0 to {LARGEST_DEGREE}", lambda n: 0 <= n <= LARGEST_DEGREE, int)


@dataclass(frozen=True)
class Command:
    """A command by the name that is typed, and its arguments."""

    name: str
    arguments: tuple[Argument, ...]

    @property
    def _module(self) -> str:
        return self.name.replace("-", "_")

    @property
    def module(self) -> ModuleType:
        """The command's module, imported now: help needs none of them."""
        return import_module(f"{__name__}.{self._module}")

    @cached_property
    def docstring(self) -> str:
        """What the command does in a sentence, and examples, from its module without importing it."""
        source = Path(__file__).with_name(f"{self._module}.py")
        return ast.get_docstring(ast.parse(source.read_bytes())) or ""

    @property
    def examples(self) -> list[str]:
        """Command lines."""
        return self.docstring.split("\n")[2:]


_ARGUMENTS: dict[str, tuple[Argument, ...]] = {
    "map": (
        *shared.MAPPING,
        shared.method("auto", "default: auto, the fast pipeline"),
        *shared.OPTIONS,
        shared.BALANCE,
    ),
    "check": (*shared.pair(optional=True), *shared.OUTPUT),
    "info": (*shared.source(), *shared.OUTPUT),
    "samples": shared.OUTPUT,
    "view": (
        *shared.source(),
        argument("sphere", "SPHERE", "its map, if there is one; else it is made, or found in an .npz", nargs="?"),
        shared.method("auto", "that makes the map; default: auto"),
        shared.BALANCE,
        choice("--show", SHOWN, "what the colours show; default: foldings", default="foldings"),
        *shared.pictures(),
    ),
    "play": (
        *shared.source(nargs="?", default="sample:dino"),
        shared.method("lai2014", "default: lai2014, the paper's"),
        shared.TOLERANCE,
        argument("--max-iterations", "N", "of each round; default: the method's", type=COUNT),
        argument("--rounds", "N", "of Algorithm 2 at the most; default: the method's", type=COUNT),
        *shared.pictures(PLAYER_SIZE),
        *shared.OUTPUT,
    ),
    "repair": (
        *shared.pair(),
        *shared.target("the repaired map, same vertex order (but .stl) and radius; - for stdout"),
        *shared.OUTPUT,
    ),
    "resample": (*shared.pair("IN"), *shared.target("the resampled surface; - for stdout"), shared.TO, *shared.OUTPUT),
    "transfer": (
        *shared.pair(),
        *shared.target("the data at the vertices of --to: .gii, .npz, or lh.NAME"),
        argument("--data", "FILE", shared.DATA_HELP, required=True),
        shared.TO,
        switch("--labels", help="take the nearest vertex's value; default: linear"),
        *shared.OUTPUT,
    ),
    "export": (
        *shared.pair(),
        *shared.target("texture: .glb or .obj (with .mtl and .png); scalar map: .ply (colours), .gii, .npz, "
                       "lh.NAME"),
        choice("--show", ("equirectangular", "octahedral", "factor", "angles"), "a texture by one of two "
               "projections or a scalar map: factor (u of the conformal factor e^2u, on the scale of equal areas) "
               "or angles (mean angle difference at each vertex, degrees)", required=True),
        argument("--image", "FILE", "the picture of a texture; default: a checkerboard"),
        *shared.OUTPUT,
    ),
    "harmonics": (
        *shared.pair("SURFACE"),
        *shared.target("coefficients: .coef as SPHARM-PDM writes them, or .npz"),
        argument("--degree", "L", "the largest degree (default: 15)", type=_DEGREE, default=15),
        shared.DATA,
        switch("--align", help="put the shape into the frame of its first-order ellipsoid"),
        argument("--template", "FILE", "with --align: coefficients of an aligned shape, which decide the directions of "
                 "the axes"),
        argument("--surface", "FILE", "write the surface that the coefficients describe, on the mesh of --to"),
        shared.TO,
        argument("--table", "FILE", "write error and power by degree, separated by tabs"),
        *shared.OUTPUT,
    ),
    "grid": (
        *shared.pair("SURFACE"),
        *shared.target("a picture (.png), or the numbers (.npz, array `grid`)"),
        shared.DATA,
        choice("--kind", ("equirectangular", "gauss"), "cell centres of a picture (default), or Gauss-Legendre "
               "latitudes", default="equirectangular"),
        argument("--rows", "N", "latitudes; twice as many longitudes (default: 180)", type=POSITIVE_COUNT,
                 default=180),
        *shared.OUTPUT,
    ),
    "register": (
        *shared.pair("MOVING"),
        argument("fixed", "FIXED", "the surface to lay it on"),
        argument("fixed_sphere", "FIXED_SPHERE", "its map"),
        *shared.target("MOVING's map in the frame of FIXED; - for stdout"),
        argument("--feature", "NAME=MOVING,FIXED", "files with what is compared, as for --data of other commands; "
                 "may be given again; default: curvature and depth of the surfaces", action="append", default=[]),
        argument("--stages", "LIST", "which stages to run, separated by commas (default: "
                 f"{','.join(STAGES)})", default=",".join(STAGES)),
        argument("--stiffness", "S", "of the elastic stage (default: 0.1, or 0.3 for features of the surfaces)",
                 type=POSITIVE),
        switch("--reflect", help="mirror MOVING (x to -x) and map it anew first"),
        switch("--show", help="open a window with both spheres, before and after, coloured by the first feature"),
        argument("--screenshot", "OUT.png", "write that as a picture; needs no display"),
        *shared.OUTPUT,
    ),
    "batch": (
        argument("sources", "IN", "mesh files, globs in quotes, or @FILE with one of them a line", nargs="*"),
        argument("--subjects-dir", "DIR", "take --surface of each subject of a FreeSurfer folder"),
        argument("--surface", "NAMES", "with --subjects-dir; default: lh.white,rh.white",
                 default="lh.white,rh.white"),
        argument("--out", "PATTERN", "where each sphere goes: {folder}, {name} and {stem} are those of IN, such as "
                 "{folder}/lh.sphere.conformal or spheres/{stem}.ply; default with --subjects-dir: "
                 "{folder}/{name}.conformal, or .balanced"),
        shared.method("auto", "default: auto"),
        *shared.OPTIONS,
        shared.BALANCE,
        argument("--jobs", "N", "processes; default: one for each processor", type=POSITIVE_COUNT),
        argument("--scheduler", "ADDRESS", "run on the workers of a Dask scheduler: tcp://HOST:8786, or its "
                 "scheduler file"),
        argument("--manifest", "FILE", "inputs and results so far, as JSON lines; default: in the folder of all "
                 "targets"),
        (("--resume",), {"help": "keep what the manifest holds of the same file, options and version; default: on",
                         "action": BooleanOptionalAction, "default": True}),
        switch("--retry-failed", help="run again what failed"),
        argument("--timeout", "SECONDS", "end a job after so long", type=POSITIVE),
        argument("--memory", "MB", "end a job that takes more", type=POSITIVE),
        argument("--retries", "N", "run a job again whose process died; default: once", type=COUNT, default=1),
        argument("--summary", "FILE", "one line for each file: .tsv, .csv or .jsonl"),
        argument("--report", "DIR", "write DIR/index.html: distributions and pictures, worst first"),
        switch("-f", "--force", help="replace any other file at a target"),
        shared.SILENT,
        *shared.REPAIR,
    ),
    "summarise": (argument("table", "TABLE", "a table of `batch --summary`, or a manifest of `batch`"),),
    "p-harmonic": (
        *shared.MAPPING,
        argument("-p", "P", "the exponent, above 1; 2 is the harmonic energy", type=_EXPONENT, required=True),
        shared.MAY_FOLD,
    ),
    "landmarks": (
        *shared.MAPPING,
        argument("--points", "FILE", "one landmark a line: vertex (from 0), then x y z of its target on the "
                 "sphere, and a weight if it is not --weight", required=True),
        argument("--weight", "W", "of squared distances to targets (default: 100)", type=FROM_ZERO, default=100.0),
        shared.MAY_FOLD,
    ),
    "reproduce": (
        argument("names", "WHAT", f"{', '.join(ITEMS)}, or {ALL}", nargs="+", choices=(*ITEMS, ALL)),
        argument("--meshes", "DIR", "folder of real counterparts of the paper's surfaces; without it samples stand "
                 "in, and nilearn's cortex if installed", type=Path),
        argument("--out", "DIR", "where results and finished runs are kept (default: reproduction); run again to "
                 "continue", type=Path, default=Path("reproduction")),
        argument("--max-iterations", "N", "of each minimisation; default: the methods' own", type=COUNT),
        shared.SILENT,
    ),
    "completion": (choice("shell", ("bash", "zsh", "tcsh"), "which shell"),),
}

COMMANDS = tuple(Command(*row) for row in _ARGUMENTS.items())
