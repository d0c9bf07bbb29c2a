"""The table of commands; each is a module here, named as the command, with `configure(parser)` and `run(args)`."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from types import ModuleType


@dataclass(frozen=True)
class Command:
    """A row of the table: the name as it is typed, what it does in a phrase, and examples, one a line."""

    name: str
    help: str
    examples: str

    @property
    def module(self) -> ModuleType:
        """The command's module, imported now: `igl-spheremap --help` needs none of them."""
        return import_module(f"{__name__}.{self.name.replace('-', '_')}")


COMMANDS = (
    Command(
        "map",
        "map a closed genus-0 mesh to the unit sphere and certify the map",
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
        """\
igl-spheremap check lh.pial lh.sphere.conformal
igl-spheremap check bunny.obj their_sphere.ply --json -
igl-spheremap check bunny_map.npz""",
    ),
    Command(
        "info",
        "measure a mesh: size, triangle quality, and limbs that float64 can't resolve on the sphere",
        """\
igl-spheremap info sample:octopus
igl-spheremap info lh.pial --json -""",
    ),
    Command("samples", "list the shapes that the package makes itself", "igl-spheremap samples"),
    Command(
        "view",
        "show a surface beside its sphere, in a window or as a picture",
        """\
igl-spheremap view sample:dino
igl-spheremap view lh.pial lh.sphere.conformal --show angles
igl-spheremap view bunny_map.npz --screenshot bunny.png""",
    ),
    Command(
        "play",
        "watch a map being computed step by step, in a window, as a picture or as a video",
        """\
igl-spheremap play sample:dino
igl-spheremap play lh.pial --method auto
igl-spheremap play bunny.ply --video bunny.gif --json bunny_frames.json
igl-spheremap play sample:dino --screenshot dino.png""",
    ),
    Command(
        "repair",
        "remove the foldings of a map, from any program",
        "igl-spheremap repair lh.pial their.sphere repaired.sphere",
    ),
    Command(
        "resample",
        "remesh a surface with the connectivity of a regular sphere, or of another map",
        """\
igl-spheremap resample lh.pial lh.sphere.conformal lh_ico5.surf.gii --to ico:5
igl-spheremap resample sub01.ply sub01_sphere.ply sub01_on_sub02.ply --to sub02_sphere.ply""",
    ),
    Command(
        "transfer",
        "carry data over a mapped surface to another one, or to an icosphere",
        """\
igl-spheremap transfer lh.pial lh.sphere.conformal lh_thickness.shape.gii --data lh.thickness --to ico:5
igl-spheremap transfer a.ply a_sphere.ply b_parcels.npz --data parcels.npz --labels --to b_sphere.ply""",
    ),
    Command(
        "export",
        "write a texture, vertex colours or a scalar map of a mapped surface",
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
        """\
igl-spheremap harmonics bunny.ply bunny_sphere.ply bunny.coef --degree 15 --table errors.tsv
igl-spheremap harmonics bunny.ply bunny_sphere.ply bunny.coef --align --surface reconstructed.ply""",
    ),
    Command(
        "grid",
        "sample a mapped surface, or data over it, on latitudes and longitudes",
        """\
igl-spheremap grid bunny.ply bunny_sphere.ply bunny_positions.npz --kind gauss --rows 64
igl-spheremap grid lh.pial lh.sphere.conformal lh_sulc.png --data lh.sulc""",
    ),
    Command(
        "register",
        "lay one mapped surface on another so that their features agree",
        """\
igl-spheremap register sub01.ply sub01_sphere.ply sub02.ply sub02_sphere.ply sub01_on_sub02.ply
igl-spheremap register rh.white rh.sphere lh.white lh.sphere rh.on_left.reg --reflect --feature sulc=rh.sulc,lh.sulc""",
    ),
    Command(
        "batch",
        "map many files by processes or on a Dask cluster; run it again to continue",
        """\
igl-spheremap batch meshes/*.ply --out spheres/{stem}.ply --jobs 4
igl-spheremap batch --subjects-dir subjects --surface lh.white,rh.white --summary white.tsv
igl-spheremap batch @files.txt --out {folder}/{stem}_sphere.ply --scheduler tcp://cluster:8786 --timeout 600""",
    ),
    Command(
        "summarise",
        "print the quantiles and the outliers of many maps",
        "igl-spheremap summarise white.tsv",
    ),
    Command(
        "p-harmonic",
        "map by the p-harmonic energy, which gives limbs more room for p above 2",
        "igl-spheremap p-harmonic sample:dino dino_sphere.obj -p 4",
    ),
    Command(
        "landmarks",
        "map harmonically with landmarks drawn towards targets",
        "igl-spheremap landmarks lh.pial lh.sphere.conformal --points landmarks.txt --weight 100",
    ),
    Command(
        "reproduce",
        "compute the paper's tables and figures, beside its own numbers",
        """\
igl-spheremap reproduce table2
igl-spheremap reproduce all --meshes ../shared/meshes --out reproduction""",
    ),
    Command(
        "completion",
        "print a script that completes command lines in a shell",
        "igl-spheremap completion bash > ~/.local/share/bash-completion/completions/igl-spheremap",
    ),
)
