"""The surfaces that stand for the paper's: files of a folder, nilearn's cortex, or samples."""

from __future__ import annotations

import csv
import hashlib
import importlib.util
from collections.abc import Iterator
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path

import igl
import numpy as np

from ... import samples
from ...errors import FileError, MeshError
from ...io.files import read_mesh
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import check_mesh


@dataclass(frozen=True)
class Counterpart:
    """What stands for a surface of the paper: a file of the folder, or a sample."""

    file: str
    relation: str
    sample: str
    sample_relation: str
    #: Number of vertices to which the file is simplified; empty if it is taken as it is.
    simplify_to: str = ""
    #: The direction of the file's that is up, if it does not show where it stands.
    up: str = "auto"


@dataclass(frozen=True, eq=False)
class PaperSurface:
    """A checked mesh under the paper's name, where it is from, and how it relates to the paper's."""

    name: str
    v: FloatArray
    f: IntArray
    source: str
    relation: str
    up: str = "auto"

    @property
    def label(self) -> str:
        """Its name, and whether it is a sample."""
        return f"{self.name} (sample)" if self.source.startswith("sample:") else self.name

    @property
    def short_source(self) -> str:
        """The name of its file, or of its sample."""
        return f"sample {self.source.split(':')[1]}" if self.source.startswith("sample:") else Path(self.source).name

    @property
    def digest(self) -> str:
        """A hash of the mesh."""
        return hashlib.sha256(self.v.tobytes() + self.f.tobytes()).hexdigest()[:16]

    def renumbered(self, seed: int) -> PaperSurface:
        """The same surface with its vertices and faces in another order: only rounding is different."""
        rng = np.random.default_rng(seed)
        order = rng.permutation(len(self.v))
        place = np.argsort(order)
        return replace(self, v=self.v[order], f=place[self.f[rng.permutation(len(self.f))]])


_GRAY_MATTER = "public/fsaverage5_pial_left.obj"
_TABLE = files(__package__).joinpath("counterparts.csv").read_text(encoding="utf-8")
#: What stands for each surface, by the paper's name of it.
COUNTERPARTS = {row.pop("surface"): Counterpart(**row) for row in csv.DictReader(_TABLE.splitlines())}


def load_surface(name: str, folder: Path | None) -> PaperSurface:
    """The surface that stands for one of `COUNTERPARTS`: from the folder, from nilearn, or a sample.

    >>> load_surface("Bird 1", None).source
    'sample:bird:n_vertices=890'
    """
    one = COUNTERPARTS[name]
    up = one.up
    if folder is not None and one.file and (folder / one.file).is_file():
        v, f = read_mesh(folder / one.file)
        source, relation = one.file, one.relation
        if one.simplify_to:
            v, f = _simplified(v, f, int(one.simplify_to))
    elif one.file == _GRAY_MATTER and (shipped := _nilearn_fsaverage()) is not None:
        v, f = read_mesh(shipped)
        source, relation = f"nilearn's {shipped.name}", one.relation
    else:
        v, f = samples.from_spec(one.sample)
        source, relation, up = f"sample:{one.sample}", one.sample_relation, "auto"
    check_mesh(v, f)
    return PaperSurface(name, v, f, source, relation, up)


def all_surfaces(folder: Path | None) -> Iterator[PaperSurface]:
    """All samples, and all closed meshes of genus 0 of a folder and its subfolders."""
    for name in samples.names():
        yield PaperSurface(name, *samples.make(name), f"sample:{name}", "the sample")
    for path in sorted(folder.rglob("*.obj")) if folder else ():
        try:
            v, f = read_mesh(path)
            check_mesh(v, f)
        except (FileError, MeshError):
            continue
        yield PaperSurface(path.stem, v, f, str(path), "the file")


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
