"""Registration of people's cortices by the labels that were drawn on them: Mindboggle-101, or folders laid out like it.

    python -m benchmarks mindboggle FOLDER [--pairs N] [--balance B] [--out FILE.csv] [--stand-in WHEELS]

FOLDER holds a folder a subject, at any depth, with `lh.labels.DKT31.manual.vtk` and `rh.labels.DKT31.manual.vtk`: a
closed surface, and one number a vertex, -1 outside of the cortex. Each subject is laid on the next N ones, by the
surfaces alone, and gets their labels; figures are the share of the area whose label is that which was drawn, and the
mean over labels of Dice's coefficient, by area, beside those of the rotation alone. Data are not part of this package:
they come from the Mindboggle project under its own terms. `--stand-in` first fills FOLDER from the wheels of
`cortices`: averages meshed anew, with labels of the HCP_MMP1 atlas, which only show that the program runs.
"""

from __future__ import annotations

import csv
from functools import cache
from pathlib import Path

import numpy as np

import igl_spheremap as ism
from igl_spheremap.io.scalars import read_scalars
from igl_spheremap.mesh.measure import vertex_areas

from .common import parser, timed
from .cortex_data import Data, anew

_FILE = "{}.labels.DKT31.manual.vtk"
_FIGURES = ("agree", "dice", "agree_rotated", "dice_rotated", "folded", "seconds")


def stand_in(folder: Path, wheels: Path) -> None:
    """Surfaces with labels, laid out as Mindboggle-101 is."""
    data = Data(wheels)
    for body in ("S1200", "Conte69", "fsaverage+1"):
        for side in "LR":
            cortex = anew(*data.surface(body, side))
            own, path = (
                cortex.label(data.labels(side)),
                folder / body / _FILE.format(f"{side.lower()}h"),
            )
            write_labels(path, cortex.v, cortex.f, np.where(own > 0, own, -1))


def write_labels(path: Path, v, f, labels) -> None:
    """A surface with labels as the Mindboggle project writes them."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w") as file:
        file.write(
            f"# vtk DataFile Version 3.0\nlabels\nASCII\nDATASET POLYDATA\nPOINTS {len(v)} float\n"
        )
        np.savetxt(file, v, "%.9g")
        file.write(f"POLYGONS {len(f)} {f.size + len(f)}\n")
        np.savetxt(file, np.column_stack((np.full(len(f), 3), f)), "%d")
        file.write(f"POINT_DATA {len(v)}\nSCALARS Labels int 1\nLOOKUP_TABLE default\n")
        np.savetxt(file, labels, "%d")


@cache
def mapped(path: Path, balance: float):
    """A subject's map, its labels, and the map's seconds."""
    mesh = ism.repair_mesh(*ism.read_mesh(path), keep_largest=True)
    labels = next(iter(read_scalars(path).values())).astype(int)
    if len(labels) != len(mesh.v):
        raise SystemExit(
            f"{path}: {len(labels)} labels, but {len(mesh.v)} vertices are left of a surface that is not "
            "closed and connected"
        )
    return *timed(lambda: ism.balanced_spherical_map(mesh.v, mesh.f, balance=balance)), labels


def overlap(areas, drawn, carried):
    """Share of the area whose labels agree, and the mean Dice coefficient, within the cortex as it was drawn."""
    inside = drawn >= 0
    areas, drawn, carried = areas[inside], drawn[inside], carried[inside]
    same = areas * (drawn == carried)
    dice = [
        2
        * same[drawn == label].sum()
        / (areas[drawn == label].sum() + areas[carried == label].sum())
        for label in np.unique(drawn)
    ]
    return same.sum() / areas.sum(), np.mean(dice)


def main(words):
    """A row for each side of each pair."""
    words_parser = parser(__doc__)
    words_parser.add_argument("folder", type=Path)
    words_parser.add_argument("--pairs", type=int, default=1, metavar="N")
    words_parser.add_argument("--balance", type=float, default=0.85)
    words_parser.add_argument("--out", type=Path, default=Path("mindboggle.csv"))
    words_parser.add_argument("--stand-in", type=Path, metavar="WHEELS")
    args = words_parser.parse_args(words)
    if args.stand_in:
        stand_in(args.folder, args.stand_in)
    with args.out.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("side", "source", "target", *_FIGURES))
        for side in ("lh", "rh"):
            paths = sorted(args.folder.rglob(_FILE.format(side)))
            if len(paths) < 2:
                raise SystemExit(
                    f"{args.folder}: {len(paths)} of {_FILE.format(side)}, give two subjects or more"
                )
            for k, path in enumerate(paths):
                for other in (paths * 2)[k + 1 : k + 1 + min(args.pairs, len(paths) - 1)]:
                    row = compared(path, other, args.balance)
                    names = side, path.parent.name, other.parent.name
                    writer.writerow((*names, *(f"{value:.4g}" for value in row)))
                    file.flush()
                    print(
                        *names,
                        ", ".join(
                            f"{key} {value:.3g}" for key, value in zip(_FIGURES, row, strict=True)
                        ),
                        flush=True,
                    )


def compared(path, other, balance):
    """Figures of one pair."""
    (a, began, drawn), (b, _, labels) = mapped(path, balance), mapped(other, balance)
    found, seconds = timed(lambda: ism.shapes.register(a, b))
    turned = ism.shapes.register(a, b, stages=["rotation"])
    areas = vertex_areas(a.vertices, a.faces)
    registered, rotated = (
        overlap(areas, drawn, ism.transfer(b, labels, each.map, labels=True))
        for each in (found, turned)
    )
    return *registered, *rotated, found.map.certificate.foldings, began + seconds
