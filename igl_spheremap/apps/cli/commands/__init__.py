"""The table of commands: purpose, arguments and examples. The work is `run(args)` in a module of its name.

Nothing here takes time to import, so that help is at once.
"""

from __future__ import annotations

from argparse import BooleanOptionalAction
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType

from ....shapes.harmonics import LARGEST_DEGREE
from ....shapes.registration import STAGES
from ...numbers import COUNT, FROM_ZERO, POSITIVE, POSITIVE_COUNT, number
from ...reproduce import ALL, ITEMS
from ...viewer.choices import PLAYER_SIZE, SHOWN
from .. import arguments as shared
from ..arguments import Argument, argument, choice, switch

_EXPONENT = number("above 1", lambda p: p > 1)
_DEGREE = number(f"from 0 to {LARGEST_DEGREE}", lambda n: 0 <= n <= LARGEST_DEGREE, int)


@dataclass(frozen=True)
class Command:
    """A row of the table: the name as it is typed, what it does in a phrase, arguments, and examples, one a line."""

    name: str
    help: str
    arguments: tuple[Argument, ...]
    examples: str

    @property
    def module(self) -> ModuleType:
        """The command's module, imported now: help needs none of them."""
        return import_module(f"{__name__}.{self.name.replace('-', '_')}")


COMMANDS = (
    Command(
        "map",
        "map a closed genus-0 mesh to the unit sphere and certify the map",
        (
            *shared.MAPPING,
            shared.method("auto", "default: auto, the fast pipeline"),
            *shared.OPTIONS,
            shared.BALANCE,
        ),
        """\
igl-spheremap map sample:dino dino_sphere.obj
igl-spheremap map lh.pial lh.sphere.conformal
igl-spheremap map bunny.ply bunny_map.npz --method lai2014 --json figures.json
igl-spheremap map bunny.ply bunny_sphere.ply --report bunny_report --plot bunny.svg
igl-spheremap map scan.stl sphere.ply --repair --keep-largest
igl-spheremap map bunny.ply bunny_sphere.ply --polish angles""",
    ),
    Command(
        "check",
        "certify a map to the sphere, from any program",
        (*shared.pair(optional=True), *shared.OUTPUT),
        """\
igl-spheremap check lh.pial lh.sphere.conformal
igl-spheremap check bunny.obj their_sphere.ply --json -
igl-spheremap check bunny_map.npz""",
    ),
    Command(
        "info",
        "measure a mesh: size, triangle quality, and limbs that float64 can't resolve on the sphere",
        (*shared.source(), *shared.OUTPUT),
        """\
igl-spheremap info sample:octopus
igl-spheremap info lh.pial --json -""",
    ),
    Command("samples", "list the shapes that the package makes itself", shared.OUTPUT, "igl-spheremap samples"),
    Command(
        "view",
        "show a surface beside its sphere, in a window or as a picture",
        (
            *shared.source(),
            argument("sphere", "SPHERE", "its map, if there is one; else it is made, or found in an .npz", nargs="?"),
            shared.method("auto", "that makes the map; default: auto"),
            shared.BALANCE,
            choice("--show", SHOWN, "by colours; default: foldings", default="foldings"),
            *shared.pictures(),
        ),
        """\
igl-spheremap view sample:dino
igl-spheremap view lh.pial lh.sphere.conformal --show angles
igl-spheremap view bunny_map.npz --screenshot bunny.png""",
    ),
    Command(
        "play",
        "watch a map being computed step by step, in a window, as a picture or as a video",
        (
            *shared.source(nargs="?", default="sample:dino"),
            shared.method("lai2014", "default: lai2014, the paper's"),
            shared.TOLERANCE,
            argument("--max-iterations", "N", "of each round; default: the method's", type=COUNT),
            argument("--rounds", "N", "of Algorithm 2 at the most; default: the method's", type=COUNT),
            *shared.pictures(PLAYER_SIZE),
            *shared.OUTPUT,
        ),
        """\
igl-spheremap play sample:dino
igl-spheremap play lh.pial --method auto
igl-spheremap play bunny.ply --video bunny.gif --json bunny_frames.json
igl-spheremap play sample:dino --screenshot dino.png""",
    ),
    Command(
        "repair",
        "remove the foldings of a map, from any program",
        (
            *shared.pair(),
            *shared.target("the repaired map, same vertex order (but .stl) and radius; - for stdout"),
            *shared.OUTPUT,
        ),
        "igl-spheremap repair lh.pial their.sphere repaired.sphere",
    ),
    Command(
        "resample",
        "remesh a surface with the connectivity of a regular sphere, or of another map",
        (*shared.pair("IN"), *shared.target("the resampled surface; - for stdout"), shared.TO, *shared.OUTPUT),
        """\
igl-spheremap resample lh.pial lh.sphere.conformal lh_ico5.surf.gii --to ico:5
igl-spheremap resample sub01.ply sub01_sphere.ply sub01_on_sub02.ply --to sub02_sphere.ply""",
    ),
    Command(
        "transfer",
        "carry data over a mapped surface to another one, or to an icosphere",
        (
            *shared.pair(),
            *shared.target("the data at the vertices of --to: .gii, .npz, or lh.NAME"),
            argument("--data", "FILE", shared.DATA_HELP, required=True),
            shared.TO,
            switch("--labels", help="take the nearest vertex's value; default: linear"),
            *shared.OUTPUT,
        ),
        """\
igl-spheremap transfer lh.pial lh.sphere.conformal lh_thickness.shape.gii --data lh.thickness --to ico:5
igl-spheremap transfer a.ply a_sphere.ply b_parcels.npz --data parcels.npz --labels --to b_sphere.ply""",
    ),
    Command(
        "export",
        "write a texture, vertex colours or a scalar map of a mapped surface",
        (
            *shared.pair(),
            *shared.target("texture: .glb or .obj (with .mtl and .png); scalar map: .ply (colours), .gii, .npz, "
                           "lh.NAME"),
            choice("--show", ("equirectangular", "octahedral", "factor", "angles"), "a texture by one of two "
                   "projections or a scalar map: factor (u of the conformal factor e^2u, on the scale of equal areas) "
                   "or angles (mean angle difference at each vertex, degrees)", required=True),
            argument("--image", "FILE", "the picture of a texture; default: a checkerboard"),
            *shared.OUTPUT,
        ),
        """\
igl-spheremap export bunny.obj bunny_sphere.obj bunny.glb --show octahedral
igl-spheremap export bunny.obj bunny_sphere.obj globe.obj --show equirectangular --image earth.png
igl-spheremap export bunny.obj bunny_sphere.obj bunny_angles.ply --show angles
igl-spheremap export lh.pial lh.sphere.conformal lh.factor.shape.gii --show factor
igl-spheremap export lh.pial lh.sphere.conformal lh.factor --show factor""",
    ),
    Command(
        "harmonics",
        "expand a mapped surface, or data over it, in spherical harmonics",
        (
            *shared.pair("SURFACE"),
            *shared.target("coefficients: .coef as SPHARM-PDM writes them, or .npz"),
            argument("--degree", "L", "the largest degree (default: 15)", type=_DEGREE, default=15),
            shared.DATA,
            switch("--align", help="put it into the frame of its first-order ellipsoid"),
            argument("--template", "FILE", "with --align: an aligned shape that decides the directions"),
            argument("--surface", "FILE", "write the surface that the coefficients describe"),
            argument("--to", "MESH", "its mesh: ico:K (default: ico:5)", default="ico:5"),
            argument("--table", "FILE", "write error and power by degree, separated by tabs"),
            *shared.OUTPUT,
        ),
        """\
igl-spheremap harmonics bunny.ply bunny_sphere.ply bunny.coef --degree 15 --table errors.tsv
igl-spheremap harmonics bunny.ply bunny_sphere.ply bunny.coef --align --surface reconstructed.ply""",
    ),
    Command(
        "grid",
        "sample a mapped surface, or data over it, on latitudes and longitudes",
        (
            *shared.pair("SURFACE"),
            *shared.target("a picture (.png), or the numbers (.npz, array `grid`)"),
            shared.DATA,
            choice("--kind", ("equirectangular", "gauss"), "cell centres of a picture (default), or Gauss-Legendre "
                   "latitudes", default="equirectangular"),
            argument("--rows", "N", "latitudes; twice as many longitudes (default: 180)", type=POSITIVE_COUNT,
                     default=180),
            *shared.OUTPUT,
        ),
        """\
igl-spheremap grid bunny.ply bunny_sphere.ply bunny_positions.npz --kind gauss --rows 64
igl-spheremap grid lh.pial lh.sphere.conformal lh_sulc.png --data lh.sulc""",
    ),
    Command(
        "register",
        "lay one mapped surface on another so that their features agree",
        (
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
        """\
igl-spheremap register sub01.ply sub01_sphere.ply sub02.ply sub02_sphere.ply sub01_on_sub02.ply
igl-spheremap register rh.white rh.sphere lh.white lh.sphere rh.on_left.reg --reflect --feature sulc=rh.sulc,lh.sulc""",
    ),
    Command(
        "batch",
        "map many files by processes or on a Dask cluster; run it again to continue",
        (
            argument("sources", "IN", "mesh files, globs in quotes, or @FILE with one of them a line", nargs="*"),
            argument("--subjects-dir", "DIR", "take --surface of each subject of a FreeSurfer folder"),
            argument("--surface", "NAMES", "with --subjects-dir; default: lh.white,rh.white",
                     default="lh.white,rh.white"),
            argument("--out", "PATTERN", "where each sphere goes: {folder}, {name} and {stem} are those of IN, such as "
                     "{folder}/lh.sphere.conformal or spheres/{stem}.ply; default with --subjects-dir: "
                     "{folder}/{name}.conformal, or .balanced"),
            shared.method("auto", "default: auto"),
            shared.BALANCE,
            argument("--jobs", "N", "processes; default: one for each processor", type=POSITIVE_COUNT),
            argument("--scheduler", "ADDRESS", "run on the workers of a Dask scheduler: tcp://HOST:8786, or its "
                     "scheduler file"),
            argument("--manifest", "FILE", "inputs and results so far, as JSON lines; default: in the folder of all "
                     "targets"),
            argument("--resume", None, "keep what the manifest holds of the same file, options and version; "
                     "default: on", action=BooleanOptionalAction, default=True),
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
        """\
igl-spheremap batch meshes/*.ply --out spheres/{stem}.ply --jobs 4
igl-spheremap batch --subjects-dir subjects --surface lh.white,rh.white --summary white.tsv
igl-spheremap batch @files.txt --out {folder}/{stem}_sphere.ply --scheduler tcp://cluster:8786 --timeout 600""",
    ),
    Command(
        "summarise",
        "print the quantiles and the outliers of many maps",
        (argument("table", "TABLE", "a table of `batch --summary`, or a manifest of `batch`"),),
        "igl-spheremap summarise white.tsv",
    ),
    Command(
        "p-harmonic",
        "map by the p-harmonic energy, which gives limbs more room for p above 2",
        (
            *shared.MAPPING,
            argument("-p", "P", "the exponent, above 1; 2 is the harmonic energy", type=_EXPONENT, required=True),
            shared.MAY_FOLD,
        ),
        "igl-spheremap p-harmonic sample:dino dino_sphere.obj -p 4",
    ),
    Command(
        "landmarks",
        "map harmonically with landmarks moved towards targets",
        (
            *shared.MAPPING,
            argument("--points", "FILE", "one landmark a line: vertex (from 0), then x y z of its target on the "
                     "sphere, and a weight if it is not --weight", required=True),
            argument("--weight", "W", "of squared distances to targets (default: 100)", type=FROM_ZERO, default=100.0),
            shared.MAY_FOLD,
        ),
        "igl-spheremap landmarks lh.pial lh.sphere.conformal --points landmarks.txt --weight 100",
    ),
    Command(
        "reproduce",
        "compute the paper's tables and figures, beside its own numbers",
        (
            argument("names", "WHAT", f"{', '.join(ITEMS)}, or {ALL}", nargs="+", choices=(*ITEMS, ALL)),
            argument("--meshes", "DIR", "folder of real counterparts of the paper's surfaces; without it samples stand "
                     "in, and nilearn's cortex if installed", type=Path),
            argument("--out", "DIR", "where results and finished runs are kept (default: reproduction); run again to "
                     "continue", type=Path, default=Path("reproduction")),
            argument("--max-iterations", "N", "of each minimisation; default: the methods' own", type=COUNT),
            shared.SILENT,
        ),
        """\
igl-spheremap reproduce table2
igl-spheremap reproduce all --meshes meshes --out reproduction""",
    ),
    Command(
        "completion",
        "print a script that completes command lines in a shell",
        (choice("shell", ("bash", "zsh", "tcsh"), "which shell"),),
        "igl-spheremap completion bash > ~/.local/share/bash-completion/completions/igl-spheremap",
    ),
)
