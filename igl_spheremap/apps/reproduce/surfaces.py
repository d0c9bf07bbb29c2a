"""The surfaces that stand for the paper's: real counterparts from a folder, or samples of this package."""

from __future__ import annotations

import csv
import hashlib
import importlib.util
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import igl
import numpy as np

from ... import samples
from ...io import read_mesh
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import check_mesh


@dataclass(frozen=True)
class Counterpart:
    """What stands for a surface of the paper: a file of the folder, simplified to so many vertices, or a sample."""

    file: str
    relation: str
    sample: str
    sample_relation: str
    simplify_to: str = ""


@dataclass(frozen=True, eq=False)
class Surface:
    """A checked mesh under the paper's name, where it is from, and how it relates to the paper's."""

    name: str
    v: FloatArray
    f: IntArray
    source: str
    relation: str

    @property
    def digest(self) -> str:
        """A hash of the mesh."""
        return hashlib.sha256(self.v.tobytes() + self.f.tobytes()).hexdigest()[:16]


_GRAY_MATTER = "public/fsaverage5_pial_left.obj"
_TABLE = files(__package__).joinpath("counterparts.csv").read_text(encoding="utf-8")
#: By the paper's name.
COUNTERPARTS = {row.pop("surface"): Counterpart(**row) for row in csv.DictReader(_TABLE.splitlines())}


def load_surface(name: str, folder: Path | None) -> Surface:
    """The surface that stands for one of `COUNTERPARTS`: from the folder, from nilearn, or a sample.

    >>> load_surface("Bird 1", None).source
    'sample:bird:n_vertices=890'
    """
    one = COUNTERPARTS[name]
    if folder is not None and one.file and (folder / one.file).is_file():
        v, f = _read(folder / one.file)
        source, relation = one.file, one.relation
        if one.simplify_to:
            v, f = _simplified(v, f, int(one.simplify_to))
    elif one.file == _GRAY_MATTER and (shipped := _nilearn_fsaverage()) is not None:
        v, f = _read(shipped)
        source, relation = f"nilearn's {shipped.name}", one.relation
    else:
        v, f = samples.from_spec(one.sample)
        source, relation = f"sample:{one.sample}", one.sample_relation
    check_mesh(v, f)
    return Surface(name, v, f, source, relation)


def _read(path: Path) -> tuple[FloatArray, IntArray]:
    mesh = read_mesh(path)
    return mesh.v, mesh.f


def _simplified(v: FloatArray, f: IntArray, n: int) -> tuple[FloatArray, IntArray]:
    """Quadric simplification to n vertices."""
    v, f, _, _ = igl.qslim(np.asfortranarray(v), np.asfortranarray(f, dtype=np.int32), 2 * n - 4)
    return np.ascontiguousarray(v), np.ascontiguousarray(f, dtype=np.int64)


def _nilearn_fsaverage() -> Path | None:
    """The pial surface that nilearn ships, if it is installed and files can be read."""
    if importlib.util.find_spec("nibabel") is None:
        return None
    spec = importlib.util.find_spec("nilearn")
    for root in (spec.submodule_search_locations or ()) if spec else ():
        path = Path(root) / "datasets" / "data" / "fsaverage5" / "pial_left.gii.gz"
        if path.is_file():
            return path
    return None
