"""Spheres of other programs' templates, by their names and in their order of vertices, from files on this machine."""

from __future__ import annotations

import os
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from ..errors import FileError, MeshError
from ..mesh.arrays import FloatArray, IntArray
from .files import read_sphere

_FINEST = 7  # fsaverage7, which FreeSurfer calls fsaverage
_BUNDLED = 5  # fsaverage5, which nilearn brings; older copies of its fsaverage3 and 4 have another order
_FSLR = 32_492
#: Names of templates that can be asked for.
TEMPLATES = (*(f"fsaverage{k}" for k in range(3, _FINEST + 1)), "fsaverage", "fsLR-32k")


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
        If the file has not the template's number of vertices.
    """
    if name not in TEMPLATES:
        raise ValueError(f"{name!r} is not a template: choose from {', '.join(TEMPLATES)}")
    if name == "fsLR-32k":
        if structure not in ("CortexLeft", "CortexRight"):
            raise FileError(f"{name} has a left and a right side, and the surface says neither: name it lh.NAME, "
                            "rh.NAME or NAME_hemi-L, or give the file of the sphere")
        return _read([_FSLR], _fslr("L" if structure == "CortexLeft" else "R"), name)
    level = _FINEST if name == "fsaverage" else int(name.removeprefix("fsaverage"))
    finer = range(max(level, _BUNDLED), _FINEST + 1)
    x, f = _read([10 * 4**k + 2 for k in finer], (path for k in finer for path in _fsaverage(k)), name)
    while len(x) > 10 * 4**level + 2:
        x, f = coarser(x, f)
    return x, f


def _read(sizes: list[int], paths: Iterator[Path], name: str) -> tuple[FloatArray, IntArray]:
    for path in paths:
        if path.is_file():
            x, f = read_sphere(path)
            if len(x) not in sizes:
                raise MeshError(f"{path} has {len(x)} vertices, not {sizes[0]}; it is not a sphere of {name}")
            return x, f
    raise FileError(f"no sphere of {name} is found in the folders of FreeSurfer, nilearn, neuromaps, TemplateFlow and "
                    "HCP; give its file")


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
        raise MeshError("the vertices are not nested: the first ones are not those of a coarser sphere")
    return x[:n], np.array(rows, dtype=np.int64)


def _fsaverage(level: int) -> Iterator[Path]:
    """Where the sphere of that level may be."""
    name = "fsaverage" if level == _FINEST else f"fsaverage{level}"
    for folder in _folders("SUBJECTS_DIR", "FREESURFER_HOME/subjects"):
        yield folder / name / "surf" / "lh.sphere"
    nilearn = find_spec("nilearn")
    bundled = [Path(place) / "datasets" / "data" for place in (nilearn and nilearn.submodule_search_locations) or ()]
    for folder in [*bundled, *_folders("NILEARN_DATA", "NILEARN_SHARED_DATA"), Path.home() / "nilearn_data"]:
        yield folder / name / "sphere_left.gii.gz"
    density = {5: "10k", 6: "41k", 7: "164k"}[level]
    for folder in _neuromaps():
        yield folder / "fsaverage" / f"tpl-fsaverage_den-{density}_hemi-L_sphere.surf.gii"
    for folder in _templateflow():
        yield folder / "tpl-fsaverage" / f"tpl-fsaverage_hemi-L_den-{density}_sphere.surf.gii"


def _fslr(side: str) -> Iterator[Path]:
    """Where the sphere of that side may be."""
    for folder in _neuromaps():
        yield folder / "fsLR" / f"tpl-fsLR_den-32k_hemi-{side}_sphere.surf.gii"
    for folder in _templateflow():
        yield folder / "tpl-fsLR" / f"tpl-fsLR_den-32k_hemi-{side}_sphere.surf.gii"
    for folder in _folders("HCPPIPEDIR/global/templates/standard_mesh_atlases"):
        yield folder / f"{side}.sphere.32k_fs_LR.surf.gii"


def _neuromaps() -> list[Path]:
    return [folder / "atlases" for folder in (*_folders("NEUROMAPS_DATA"), Path.home() / "neuromaps-data")]


def _templateflow() -> list[Path]:
    return [*_folders("TEMPLATEFLOW_HOME"), Path.home() / ".cache" / "templateflow"]


def _folders(*names: str) -> list[Path]:
    """Folders that variables of the environment name, and folders within."""
    pairs = (name.partition("/") for name in names)
    return [Path(os.environ[variable], inner) for variable, _, inner in pairs if os.environ.get(variable)]
