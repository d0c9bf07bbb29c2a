"""The table of commands: their purposes, examples, and arguments; nothing here takes time to import.

The work of a command is a function `run_...` of a module in `commands/`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from ...balance import AREA_PRESERVING, CONFORMAL, IN_PLANE
from ...io.formats import CONVENTIONS
from ...shapes.correspondence import STAGES, STIFFNESS, USUAL
from ...shapes.harmonics import LARGEST_DEGREE
from ..reproduce.items import ALL, ITEMS
from ..viewer.choices import CARRIED, KEEP, ROW_SIZE, SHOWN
from .arguments import (
    COUNT,
    DATA,
    DATA_HELP,
    ENDS,
    ENGINE,
    FEATURE,
    FROM_ZERO,
    MANY,
    METHOD_OPTIONS,
    OUTPUT,
    PARTS,
    PLANE,
    POSITIVE,
    POSITIVE_COUNT,
    RATINGS,
    READING,
    REFLECT,
    REPORT,
    SOURCES,
    TO,
    UP,
    Argument,
    argument,
    balance,
    choice,
    goes_with,
    method,
    number,
    pair,
    pictures,
    several,
    source,
    switch,
    target,
)

#: Flags that show a map between surfaces.
_SHOWING = "--show, --screenshot, --video"


@dataclass(frozen=True)
class Command:
    """A command: its name, the module of its work, its purpose, command lines, and arguments."""

    name: str
    module: str
    purpose: str
    lines: str
    arguments: tuple[Argument, ...]

    @property
    def examples(self) -> list[str]:
        """Its command lines."""
        return [line.strip() for line in self.lines.strip().splitlines()]

    @property
    def run(self) -> Callable[..., Any]:
        """The command's work, imported now: help needs none of it."""
        work = import_module(f"{__package__}.commands.{self.module}")
        function: Callable[..., Any] = getattr(work, f"run_{self.name.replace('-', '_')}")
        return function


def _degree(least: int) -> Argument:
    """The degree of an expansion."""
    allowed = number(int, least, LARGEST_DEGREE)
    return argument("--degree", "L", "the largest degree of harmonics", allowed, 15)


COMMANDS = (
    Command(
        "map",
        "map",
        "Map a closed genus-0 mesh to the unit sphere and certify the map.",
        """
        igl-spheremap map sample:bunny bunny_sphere.obj
        igl-spheremap map lh.pial lh.sphere.conformal
        igl-spheremap map bunny.ply bunny_map.npz --method lai2014 --json figures.json
        igl-spheremap map bunny.ply bunny_sphere.ply --report bunny_report --plot bunny.svg
        igl-spheremap map scan.stl sphere.ply --repair --keep-largest
        igl-spheremap map bunny.ply bunny_sphere.ply --polish angles
        """,
        (
            *source(),
            *target(
                "the sphere, same vertex order (but .stl); .npz holds the whole result; - for stdout"
            ),
            method("auto"),
            *METHOD_OPTIONS,
            balance(CONFORMAL),
            argument(
                "--radius",
                "R",
                "of the sphere in OUT; without it 100 for GIFTI and FreeSurfer, 1 elsewhere",
                POSITIVE,
            ),
            switch(
                "--with-surface",
                "write the surface with the sphere beside it: x y z px py pz of a .ply file",
            ),
            REPORT,
            goes_with("--report", UP),
            argument(
                "--plot", "FILE", "draw energy, foldings and angle differences: .png, .svg or .pdf"
            ),
            *OUTPUT,
        ),
    ),
    Command(
        "check",
        "check",
        "Certify a map to the sphere, or of a surface with a boundary to the plane, from any program.",
        """
        igl-spheremap check lh.pial lh.sphere.conformal
        igl-spheremap check bunny.obj their_sphere.ply --json -
        igl-spheremap check bunny_map.npz
        igl-spheremap check lh.white their.sphere --directions
        igl-spheremap check lh.white lh.cortex.patch.flat
        igl-spheremap check face_flat.obj
        """,
        (
            *pair(optional=True),
            switch(
                "--directions",
                "certify the directions of the vertices, whatever their distances",
            ),
            REFLECT,
            *OUTPUT,
        ),
    ),
    Command(
        "disk",
        "plane",
        "Map a surface with one boundary loop to the unit disk and certify the map.",
        """
        igl-spheremap disk face.ply face_disk.obj
        igl-spheremap disk face.ply face_disk.npz --balance 1 --plot face_disk.png
        """,
        (*PLANE, balance(CONFORMAL)),
    ),
    Command(
        "flatten",
        "plane",
        "Lay a surface with one boundary loop out in the plane, without folds and overlaps.",
        """
        igl-spheremap flatten face.ply face_flat.obj
        igl-spheremap flatten bunny.obj bunny_uv.obj --cut 4
        igl-spheremap flatten scan.ply scan_flat.glb --repair --fill-holes --rim 0,0,-50
        igl-spheremap flatten lh.white lh.cortex.patch.flat --patch lh.cortex.patch.3d
        igl-spheremap flatten lh.white lh.flat.obj --patch fsaverage/surf/lh.cortex.patch.3d --via lh.sphere.reg
        """,
        (*PLANE, balance(IN_PLANE)),
    ),
    Command(
        "info",
        "info",
        "Measure any mesh: its parts, holes and handles, sizes and angles, and the effect of --repair.",
        """
        igl-spheremap info sample:octopus
        igl-spheremap info scan.stl
        igl-spheremap info lh.pial --json -
        igl-spheremap info cells.obj --parts
        igl-spheremap info lh.orig.nofix --repair --cut-handles --write lh.orig.repaired
        """,
        (
            *source(),
            PARTS,
            argument("--write", "FILE", "a new file with the surface as it is measured: repaired"),
            *OUTPUT,
        ),
    ),
    Command(
        "view",
        "view",
        "Show a surface beside its sphere, or its map to the plane, in a window or as a picture.",
        """
        igl-spheremap view sample:dino
        igl-spheremap view lh.pial lh.sphere.conformal --show angles
        igl-spheremap view bunny_map.npz --screenshot bunny.png
        """,
        (
            *source(),
            argument(
                "sphere", "SPHERE", "its map; without it a new one, or that of an .npz", nargs="?"
            ),
            method("auto"),
            balance(CONFORMAL),
            choice("--show", SHOWN, "subject of the colours", "foldings"),
            *pictures(),
            *OUTPUT,
        ),
    ),
    Command(
        "play",
        "view",
        "Watch a map being computed step by step, in a window, as a picture or as a video.",
        """
        igl-spheremap play sample:dino
        igl-spheremap play lh.pial --method auto
        igl-spheremap play bunny.ply --video bunny.gif --json bunny_frames.json
        igl-spheremap play sample:dino --screenshot dino.png
        """,
        (
            *source(nargs="?", default="sample:dino"),
            method("lai2014"),
            *ENDS,
            argument("--rounds", "N", "the most rounds of Algorithm 2", COUNT),
            argument(
                "--keep",
                "MB",
                "megabytes of iterations to keep; of a run that takes more, starts, ends and changes "
                "of foldings stay",
                POSITIVE,
                KEEP,
            ),
            *pictures(),
            *OUTPUT,
        ),
    ),
    Command(
        "repair",
        "check",
        "Remove the foldings of a map, from any program.",
        """
        igl-spheremap repair lh.pial their.sphere repaired.sphere
        """,
        (
            *pair(),
            *target("the repaired map, same vertex order (but .stl) and radius; - for stdout"),
            *OUTPUT,
        ),
    ),
    Command(
        "resample",
        "transfer",
        "Remesh a surface with the connectivity of a regular sphere, or of another map.",
        """
        igl-spheremap resample lh.pial lh.sphere.conformal lh_ico5.surf.gii --to ico:5
        igl-spheremap resample sub01.ply sub01_sphere.ply sub01_on_sub02.ply --to sub02_sphere.ply
        """,
        (
            *pair("IN"),
            *target("the resampled surface; - for stdout"),
            TO,
            REFLECT,
            *OUTPUT,
        ),
    ),
    Command(
        "transfer",
        "transfer",
        "Carry data over a mapped surface to another one, or to an icosphere.",
        """
        igl-spheremap transfer lh.pial lh.sphere.conformal lh_thickness.shape.gii --data lh.thickness --to ico:5
        igl-spheremap transfer a.ply a_sphere.ply b_parcels.npz --data parcels.npz --labels --to b_sphere.ply
        igl-spheremap transfer lh.white lh.sphere.reg lh.aparc.label.gii --data lh.aparc.annot --to other.sphere
        igl-spheremap transfer lh.white lh.sphere.reg area.shape.gii --data lh.area --to ico:5 --method adaptive-area
        """,
        (
            *pair(),
            *target("the data at the vertices of --to, in a format of --data"),
            argument("--data", "FILE", DATA_HELP, required=True),
            TO,
            switch(
                "--labels",
                "take the value of the vertex with the largest weight, no weighted sum",
            ),
            choice(
                "--method",
                ("linear", "adaptive-area"),
                "adaptive-area keeps integrals, as HCP's ADAP_BARY_AREA",
                "linear",
            ),
            argument(
                "--matrix",
                "FILE",
                "write the weights by scipy.sparse.save_npz, for values @ matrix",
            ),
            REFLECT,
            *OUTPUT,
        ),
    ),
    Command(
        "export",
        "export",
        "Write a texture, vertex colours or a scalar map of a mapped surface.",
        """
        igl-spheremap export bunny.obj bunny_sphere.obj bunny.glb
        igl-spheremap export bunny.obj bunny_sphere.obj globe.obj --show equirectangular --image earth.png
        igl-spheremap export fox.glb fox_sphere.npz fox_octahedral.glb --texture baked --repair
        igl-spheremap export face.obj face_flat.obj face_new.obj --texture baked
        igl-spheremap export bunny.obj bunny_sphere.obj bunny_angles.ply --show angles
        igl-spheremap export lh.pial lh.sphere.conformal lh.factor.shape.gii --show factor
        igl-spheremap export lh.pial lh.sphere.conformal lh.factor --show factor
        """,
        (
            *pair(optional=True),
            *target(
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
            UP,
            *OUTPUT,
        ),
    ),
    Command(
        "harmonics",
        "harmonics",
        "Expand mapped surfaces, or data over one, in spherical harmonics.",
        """
        igl-spheremap harmonics bunny.ply bunny_sphere.ply bunny.coef --degree 15 --table errors.tsv
        igl-spheremap harmonics bunny.ply bunny_sphere.ply bunny.coef --align --surface reconstructed.ply
        igl-spheremap harmonics "subjects/*.ply" spheres/{stem}.ply coefficients.tsv --align --modes 5
        """,
        (
            *pair("SURFACE"),
            *target(
                ".coef as SPHARM-PDM writes it, or .npz; of many surfaces, "
                "SPHERE being such as spheres/{stem}.ply, one .tsv, .csv or .npz table"
            ),
            _degree(0),
            DATA,
            switch("--align", "put shapes into the frames of their first-order ellipsoids"),
            argument(
                "--modes",
                "K",
                "of many surfaces: principal components, whose scores come first",
                POSITIVE_COUNT,
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
            goes_with("--surface", TO),
            argument("--table", "FILE", "write error and power by degree: .tsv or .csv"),
            *OUTPUT,
        ),
    ),
    Command(
        "grid",
        "harmonics",
        "Sample a mapped surface, or data over it, on a grid of the sphere.",
        """
        igl-spheremap grid bunny.ply bunny_sphere.ply bunny_positions.npz --kind gauss --rows 64
        igl-spheremap grid bunny.ply bunny_sphere.ply bunny_mwss.npz --kind equiangular --rows 65 --columns 128
        igl-spheremap grid lh.pial lh.sphere.conformal lh_sulc.png --data lh.sulc
        igl-spheremap grid bunny.ply bunny_sphere.ply bunny_image.npz --kind octahedral --rows 129
        """,
        (
            *pair("SURFACE"),
            *target("a picture (.png), or the numbers (.npz, array `grid`, or .npy)"),
            DATA,
            choice(
                "--kind",
                ("equirectangular", "equiangular", "gauss", "octahedral"),
                "cell centres of a picture; equal "
                "steps from pole to pole; Gauss-Legendre latitudes; or the square of which `mesh` makes a mesh again",
                "equirectangular",
            ),
            argument(
                "--rows",
                "N",
                "rows; without it 180, of the octahedral square 181",
                POSITIVE_COUNT,
            ),
            argument(
                "--columns",
                "N",
                "columns; without it twice the rows, of the square as many",
                POSITIVE_COUNT,
            ),
            *OUTPUT,
        ),
    ),
    Command(
        "mesh",
        "harmonics",
        "Make a mesh of a geometry image: positions on the octahedral square.",
        """
        igl-spheremap mesh bunny_image.npz bunny_regular.ply
        """,
        (
            argument(
                "image",
                "IMAGE",
                "positions that `grid --kind octahedral` wrote: .npz (array `grid`) or .npy",
            ),
            *target("the mesh"),
            *OUTPUT,
        ),
    ),
    Command(
        "register",
        "register",
        "Lay one mapped surface on another so that their features agree.",
        """
        igl-spheremap register sub01.ply sub01_sphere.ply sub02.ply sub02_sphere.ply sub01_on_sub02.ply
        igl-spheremap register rh.white rh.sphere lh.white lh.sphere rh.lh.reg --reflect --feature sulc=rh.sulc,lh.sulc
        """,
        (
            *pair(),
            argument("other", "TARGET", "the surface to lay it on"),
            argument("other_sphere", "TARGET_SPHERE", "its map"),
            *target("SOURCE's map in the frame of TARGET; - for stdout"),
            FEATURE,
            argument(
                "--stages", "LIST", f"which of {', '.join(STAGES)} to run", default=",".join(USUAL)
            ),
            argument(
                "--stiffness",
                "S",
                "weight of the strains beside the features' differences",
                POSITIVE,
                STIFFNESS,
            ),
            switch(
                "--reflect",
                "register the mirror image of SOURCE (x to -x); OUT fits SOURCE as it is",
            ),
            switch(
                "--show",
                "open a window with both spheres, before and after, coloured by the first feature",
            ),
            argument("--screenshot", "OUT.png", "write that as a picture; needs no display"),
            *OUTPUT,
        ),
    ),
    Command(
        "match",
        "match",
        "Map one surface onto another with low distortion, bijectively, with landmarks met.",
        """
        igl-spheremap match cat.ply horse.ply horse_as_cat.ply
        igl-spheremap match cat.ply horse.ply cat_to_horse.npz --landmarks cat.vts horse.vts --video morph.gif
        igl-spheremap match rh.white lh.white lh_on_rh.npz --reflect --feature sulc=rh.sulc,lh.sulc
        """,
        (
            *source("SOURCE"),
            argument(
                "other",
                "TARGET",
                "the surface to map it to; the map in an .npz is kept, others are mapped at "
                "balance 1",
            ),
            *target(
                "TARGET's positions on the connectivity of SOURCE; .npz holds the whole map; - for stdout"
            ),
            argument(
                "--landmarks",
                ("SOURCE", "TARGET"),
                "corresponding vertices, which are met exactly: .pinned or .vts lists",
                nargs=2,
            ),
            several(
                "--curve",
                ("SOURCE", "TARGET"),
                "corresponding curves, such lists of neighbouring vertices, "
                "which meet at the same share of their lengths",
                nargs=2,
            ),
            switch("--soft", "if the landmarks can't be met, come near them"),
            FEATURE,
            argument(
                "--feature-weight",
                "W",
                "of the features' squared differences beside the strain",
                FROM_ZERO,
                0.4,
            ),
            switch("--reflect", "match the mirror image of SOURCE (x to -x); OUT has it, too"),
            argument(
                "--overlay",
                ("ON_SOURCE", "ON_TARGET"),
                "write the common refinement with its positions on each",
                nargs=2,
            ),
            goes_with(
                _SHOWING,
                choice("--colours", CARRIED, "subject of the pictures of both", CARRIED[0]),
            ),
            switch("--show", "open a window with both and the surfaces between"),
            *pictures(ROW_SIZE, shown_by=_SHOWING),
            *OUTPUT,
        ),
    ),
    Command(
        "template",
        "template",
        "Make the mean of many surfaces, its modes, and a table of scores.",
        """
        igl-spheremap template "subjects/*.ply" --out group
        igl-spheremap template --add new.ply --out group
        igl-spheremap template --design subjects.tsv --out group
        igl-spheremap template --series "frames/*.ply" --out cell
        """,
        (
            SOURCES,
            argument(
                "--out",
                "DIR",
                "folder of the group: archive, mean surface, table, page and the members' maps",
                required=True,
            ),
            switch("--series", "follow points of one body, whose frames IN are in their order"),
            several(
                "--feature",
                "NAME=PATTERN",
                "data over the vertices of each IN, as "
                "{folder}/{stem}.thickness or {folder}/{stem}.npz:NAME",
            ),
            argument("--modes", "K", "number of principal modes", POSITIVE_COUNT, 10),
            argument(
                "--to",
                "ico:K",
                "the mean's mesh, of 10 * 4^K + 2 vertices; cortices need ico:5",
                default="ico:4",
            ),
            balance(AREA_PRESERVING),
            switch("--rigid", "keep the members' sizes; without it shapes are compared"),
            several("--exclude", "IN", "leave this one of the surfaces out"),
            RATINGS,
            *ENGINE,
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
                "test the dependence on each column of this .tsv or .csv table beside the others; "
                "the first one names the members of the group in DIR",
            ),
            argument(
                "--of",
                "DATA",
                "tests shapes, scores, or a feature of the group",
                default="shapes",
            ),
            argument("--permutations", "N", "of a test", POSITIVE_COUNT, 1000),
            switch(
                "--augment",
                "test with permuted copies of the covariates: for few members and skewed data",
            ),
            switch("--force", "replace the group in DIR", "-f"),
            *OUTPUT,
        ),
    ),
    Command(
        "batch",
        "batch",
        "Map many files by processes or on a Dask cluster; run it again to continue.",
        """
        igl-spheremap batch meshes/*.ply --out spheres/{stem}.ply --jobs 4
        igl-spheremap batch "subjects/*/surf/?h.white" --out {folder}/{name}.conformal --summary white.tsv
        igl-spheremap batch cells.obj --parts --out cells/{stem}.ply
        igl-spheremap batch @files.txt --out {folder}/{stem}_sphere.ply --scheduler tcp://cluster:8786 --timeout 600
        """,
        (
            SOURCES,
            PARTS,
            argument(
                "--out",
                "PATTERN",
                "path of each sphere: {folder}, {name} and {stem} are those of IN, such as "
                "{folder}/lh.sphere.conformal or spheres/{stem}.ply",
                required=True,
            ),
            method("auto"),
            *METHOD_OPTIONS,
            balance(CONFORMAL),
            *MANY,
            *READING[1:],
        ),
    ),
    Command(
        "sphere-reg",
        "sphere_reg",
        "Register cortical surfaces to fsaverage or fsLR, and write the files that pipelines expect.",
        """
        igl-spheremap sphere-reg sub-01_hemi-L_white.surf.gii --to fsaverage --to fsLR --out derivatives
        igl-spheremap sphere-reg "subjects/*/surf/?h.white" --out reg/{subject}/surf --names freesurfer --report quality
        igl-spheremap sphere-reg lh.white --to fsaverage5 --labels {hemi}.aparc.annot --out lh_on_right --reflect
        """,
        (
            SOURCES,
            several(
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
            several(
                "--names",
                "CONVENTION",
                f"conventions of file names: {', '.join(CONVENTIONS)}; without it bids",
                choices=CONVENTIONS,
            ),
            several(
                "--labels",
                "FILE",
                "labels on a template, .annot or .label.gii, to be carried to the "
                "surfaces; {hemi} is lh or rh, {side} L or R",
            ),
            switch(
                "--reflect",
                "register mirror images (x to -x) to the templates of the other side",
            ),
            choice("--hemi", ("L", "R"), "the side, if neither the name nor the file tells it"),
            argument(
                "--pial",
                "FILE",
                "the pial surface of a white one, or a pattern with {folder}, {subject}, {hemi} and {side}; "
                "without it the file beside it that is called pial",
            ),
            *MANY,
        ),
    ),
    Command(
        "spharm-pdm",
        "spharm_pdm",
        "Map and expand surfaces into the files that SPHARM-PDM's programs write, one process each.",
        """
        igl-spheremap spharm-pdm "surfaces/*_surf.vtk" --out shapes
        igl-spheremap spharm-pdm "surfaces/*.ply" --out shapes --template shapes/first_surf_SPHARM_ellalign.coef
        """,
        (
            SOURCES,
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
                number(int, 1, 1000),
                10,
            ),
            argument(
                "--template",
                "FILE",
                "an ellalign.coef that directs each body's axes; without it their own third "
                "moments",
            ),
            balance(AREA_PRESERVING),
            *MANY,
        ),
    ),
    Command(
        "reproduce",
        "reproduce",
        "Compute the paper's tables and figures, beside its own numbers.",
        """
        igl-spheremap reproduce table2
        igl-spheremap reproduce all --meshes meshes --out reproduction
        """,
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
                Path,
            ),
            argument(
                "--out",
                "DIR",
                "folder of results and finished runs; run again to continue",
                Path,
                Path("reproduction"),
            ),
            argument(
                "--max-iterations",
                "N",
                "of each minimisation; without it the methods' own",
                COUNT,
            ),
            switch("--quiet", "print nothing", "-q"),
        ),
    ),
)

#: Subjects of the commands, in the order of the help; those of `SHAPES` call `igl_spheremap.shapes`.
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
