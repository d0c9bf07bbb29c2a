"""The surfaces that stand for the paper's: files of a folder, or samples."""

from __future__ import annotations

import csv
import hashlib
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import igl
import numpy as np

from ... import samples
from ...io.files import read_mesh
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import check_mesh


@dataclass(frozen=True)
class Counterpart:
    """Substitute of a surface of the paper: a file of the folder, or a sample."""

    file: str
    relation: str
    sample: str
    sample_relation: str
    #: Number of vertices to which the file is simplified; empty if it is taken as it is.
    simplify_to: str = ""
    #: The up direction of the file, if the shape does not show it.
    up: str = "auto"


@dataclass(frozen=True, eq=False)
class PaperSurface:
    """A checked mesh under the paper's name, its origin, and its relation to the paper's."""

    name: str
    v: FloatArray
    f: IntArray
    source: str
    relation: str
    up: str = "auto"

    @property
    def title(self) -> str:
        """The surface and its substitute."""
        return f"{self.name}: {self.relation} ({self.source}; {len(self.v):,} vertices)"

    @property
    def digest(self) -> str:
        """A hash of the mesh."""
        return hashlib.sha256(self.v.tobytes() + self.f.tobytes()).hexdigest()[:16]


_TABLE = files(__package__).joinpath("counterparts.csv").read_text(encoding="utf-8")
#: Substitute of each surface, by the paper's name.
COUNTERPARTS = {
    row.pop("surface"): Counterpart(**row) for row in csv.DictReader(_TABLE.splitlines())
}


def load_surface(name: str, folder: Path | None) -> PaperSurface:
    """The surface that stands for one of `COUNTERPARTS`: a file of the folder, or, if that lacks it, a sample.

    >>> load_surface("Bird 1", None).title
    'Bird 1: another bird (sample bird; 954 vertices)'
    """
    one = COUNTERPARTS[name]
    if folder is not None and one.file and (folder / one.file).is_file():
        v, f = read_mesh(folder / one.file)
        source, relation, up = Path(one.file).stem, one.relation, one.up
        if one.simplify_to:
            source += f", from {len(v):,} vertices"
            v, f = _simplified(v, f, int(one.simplify_to))
    else:
        v, f = samples.from_spec(one.sample)
        source, relation, up = f"sample {one.sample.partition(':')[0]}", one.sample_relation, "auto"
    check_mesh(v, f)
    return PaperSurface(name, v, f, source, relation, up)


def _simplified(v: FloatArray, f: IntArray, n: int) -> tuple[FloatArray, IntArray]:
    """Quadric simplification to n vertices."""
    v, f, _, _ = igl.qslim(np.asfortranarray(v), np.asfortranarray(f, dtype=np.int32), 2 * n - 4)
    return np.ascontiguousarray(v), np.ascontiguousarray(f, dtype=np.int64)
