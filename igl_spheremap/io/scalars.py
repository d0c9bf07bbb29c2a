"""Maps over the vertices, of numbers or of labels: GIFTI, FreeSurfer's files, NPZ, VTK; and lists of vertices."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FileError, MeshError, printable
from ..mesh.arrays import FloatArray, IntArray
from . import annot, freesurfer, gifti, npz
from .formats import FORMATS, HEMISPHERES, PathLike, format_of
from .reading import read_lines, reading
from .records import Label, Metadata
from .replacing import replacing

#: Suffixes of lists of landmarks: vertices of a surface, without positions on a sphere.
LANDMARK_LISTS = (".pinned", ".vts")


def read_scalars(path: PathLike) -> dict[str, FloatArray]:
    """Read scalar maps over the vertices of a mesh.

    Parameters
    ----------
    path : str or path-like
        A .gii file, an .npz file with arrays of one dimension, a .vtk or .vtp file with point data, an .annot file, or
        else a curvature file of FreeSurfer.

    Returns
    -------
    dict of (n,) float64 arrays
        Values by name; of labels their keys, which `read_labels` explains.

    Raises
    ------
    FileError
        If the file can't be opened, or the package that reads it is not installed.
    MeshError
        If it holds no scalar map.
    """
    source = Path(path)
    with reading(source):
        arrays = _functions(source)[0](source)
        maps = {printable(name): values.astype(np.float64) for name, values in arrays.items()
                if values.ndim == 1 and values.dtype.kind in "fiu"}
        if not maps:
            raise MeshError("the file holds no scalar map: no array has one number a vertex")
        return maps


def read_labels(path: PathLike) -> tuple[Label, ...] | None:
    """Read the table of labels of a file whose maps are labels.

    Parameters
    ----------
    path : str or path-like
        As for `read_scalars`.

    Returns
    -------
    tuple of Label, or None
        Key, name and colour of each label, in the file's order; None if the file does not say that it holds labels.

    Raises
    ------
    FileError, MeshError
        As from `read_scalars`.

    Examples
    --------
    >>> import os, tempfile
    >>> from igl_spheremap.io.records import Label
    >>> from igl_spheremap.io.scalars import read_labels, write_scalars
    >>> table = (Label(0, "rest", (0.0, 0.0, 0.0, 0.0)), Label(1, "V1", (1.0, 0.0, 0.0, 1.0)))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = os.path.join(folder, "lh.areas.annot")
    ...     write_scalars(path, {"areas": np.array([0, 1, 1, 0])}, metadata={"labels": table})
    ...     read_labels(path) == table
    True
    """
    source = Path(path)
    with reading(source):
        read = _functions(source)[2]
        return None if read is None else read(source)


def write_scalars(
    path: PathLike,
    maps: Mapping[str, FloatArray],
    *,
    force: bool = False,
    metadata: Metadata | None = None,
) -> None:
    """Write scalar maps over the vertices of a mesh.

    Parameters
    ----------
    path : str or path-like
        The new file: .gii (one data array each, float32), a name that starts with lh. or rh. (one map, as
        FreeSurfer writes curvature, float32), .annot (one map of labels), or .npz.
    maps : dict of (n,) arrays
        Values by name.
    force : bool
        Replace an existing file.
    metadata : dict, optional
        As `read_mesh` gave it for the surface; nothing by default. With ``labels``, a table as `read_labels` gives it,
        the values are labels: whole numbers (int32 in .gii files), and the table is written, too. An .annot file
        renumbers labels by their places in the table.

    Raises
    ------
    MeshError
        If labels are not whole numbers, or of an .annot file have no table or not each a colour of its own.
    FileError
        If the format is another one, the file exists and `force` is not set, or writing fails.
    """
    target, known = Path(path), metadata or {}
    _, write, _ = _functions(target)
    if "labels" in known:
        for name, values in maps.items():
            if not (np.abs(values) < 2**31).all() or (values != np.floor(values)).any():
                raise MeshError(f"{name} holds no labels: they are whole numbers of at most 32 bits")
    if write is freesurfer.write_scalars and not target.name.startswith(HEMISPHERES):
        raise FileError(f"{path}: scalar maps are written to .gii, .npz, .annot, and lh.NAME or rh.NAME files")
    if write in (freesurfer.write_scalars, annot.write_scalars) and len(maps) != 1:
        raise FileError(f"{path}: FreeSurfer's files hold one map, not {len(maps)}: {', '.join(maps)}")
    with replacing(path, force) as partial:
        write(partial, dict(maps), known)


_ReadTable = Callable[[Path], tuple[Label, ...] | None]


def _functions(path: Path) -> tuple[Callable[[Path], dict[str, NDArray[Any]]], Callable[..., None], _ReadTable | None]:
    """What reads maps from files of that name, what writes them, and what reads tables of labels."""
    if path.name.lower().endswith(annot.SUFFIX):
        return annot.read_scalars, annot.write_scalars, annot.read_table
    kind = next((entry.name for entry in FORMATS if path.name.lower().endswith(entry.suffixes)), "")
    if kind == "GIFTI":
        return gifti.read_scalars, gifti.write_scalars, gifti.read_table
    if kind == "NPZ":
        return npz.read_arrays, npz.write_scalars, npz.read_table
    if kind in ("VTK", "VTP"):
        return _point_data, freesurfer.write_scalars, None
    return freesurfer.read_scalars, freesurfer.write_scalars, None


def _point_data(path: Path) -> dict[str, NDArray[Any]]:
    """What a file of VTK holds over its points."""
    data: dict[str, NDArray[Any]] = dict(format_of(path).read(path).metadata.get("point_data", {}))
    return data


def read_landmarks(path: PathLike) -> IntArray:
    """Read a list of landmarks: vertices, of which each corresponds to the one in the same line of another list.

    Parameters
    ----------
    path : str or path-like
        A .pinned file of surface-maps-via-adaptive-triangulations, a vertex a line, or behind ``lk``; or a .vts file of
        the SHREC 2007 benchmark, a vertex a line, and perhaps its position.

    Returns
    -------
    (k,) int64 array
        Vertices, from 0, in the order of the file.

    Raises
    ------
    FileError
        If the file can't be read, or a line is of another form.

    Examples
    --------
    >>> import os, tempfile
    >>> from igl_spheremap.io.scalars import read_landmarks
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = os.path.join(folder, "bird.pinned")
    ...     with open(path, "w") as file:
    ...         _ = file.write("lk 8\\nlk 11546\\n")
    ...     read_landmarks(path).tolist()
    [8, 11546]
    """
    vertices = []
    for number, line in enumerate(read_lines(path), 1):
        words = line.partition("#")[0].split()
        words = words[1:] if words[:1] == ["lk"] else words
        if not words:
            continue
        if len(words) not in (1, 4) or not (words[0].isascii() and words[0].isdigit() and len(words[0]) < 19):
            raise FileError(f"{path}, line {number}: give a vertex, from 0, and nothing or its position behind it")
        vertices.append(int(words[0]))
    if not vertices:
        raise FileError(f"{path} has no landmarks")
    return np.array(vertices, dtype=np.int64)
