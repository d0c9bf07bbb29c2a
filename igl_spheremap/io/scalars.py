"""Scalar maps over the vertices: GIFTI, FreeSurfer's curvature files, NPZ, point data of VTK; and lists of vertices."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FileError, MeshError, printable
from ..mesh.arrays import FloatArray, IntArray
from . import freesurfer, gifti, npz
from .formats import FORMATS, PathLike, format_of
from .reading import read_lines, reading
from .records import Metadata
from .replacing import replacing

_HEMISPHERES = ("lh.", "rh.")
#: Suffixes of lists of landmarks: vertices of a surface, without positions on a sphere.
LANDMARK_LISTS = (".pinned", ".vts")


def read_scalars(path: PathLike) -> dict[str, FloatArray]:
    """Read scalar maps over the vertices of a mesh.

    Parameters
    ----------
    path : str or path-like
        A .gii file, an .npz file with arrays of one dimension, a .vtk or .vtp file with point data, or else a curvature
        file of FreeSurfer.

    Returns
    -------
    dict of (n,) float64 arrays
        Values by name.

    Raises
    ------
    FileError
        If the file can't be opened, or the package that reads it is not installed.
    MeshError
        If it holds no scalar map.
    """
    source = Path(path)
    with reading(source):
        read, _ = _functions(source)
        arrays = read(source)
        maps = {printable(name): values.astype(np.float64) for name, values in arrays.items()
                if values.ndim == 1 and values.dtype.kind in "fiu"}
        if not maps:
            raise MeshError("the file holds no scalar map: no array has one number a vertex")
        return maps


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
        FreeSurfer writes curvature, float32), or .npz.
    maps : dict of (n,) float64 arrays
        Values by name.
    force : bool
        Replace an existing file.
    metadata : dict, optional
        As `read_mesh` gave it for the surface; nothing by default.

    Raises
    ------
    FileError
        If the format is another one, the file exists and `force` is not set, or writing fails.
    """
    target, known = Path(path), metadata or {}
    _, write = _functions(target)
    if write is freesurfer.write_scalars and not target.name.lower().startswith(_HEMISPHERES):
        raise FileError(f"{path}: scalar maps are written to .gii, .npz, and lh.NAME or rh.NAME files")
    if write is freesurfer.write_scalars and len(maps) != 1:
        raise FileError(f"{path}: FreeSurfer's files hold one map, not {len(maps)}: {', '.join(maps)}")
    with replacing(path, force) as partial:
        write(partial, dict(maps), known)


def _functions(path: Path) -> tuple[Callable[[Path], dict[str, NDArray[Any]]], Callable[..., None]]:
    """What reads scalar maps from files of that name, and what writes them."""
    kind = next((entry.name for entry in FORMATS if path.name.lower().endswith(entry.suffixes)), "")
    if kind == "GIFTI":
        return gifti.read_scalars, gifti.write_scalars
    if kind == "NPZ":
        return npz.read_arrays, npz.write_arrays
    if kind in ("VTK", "VTP"):
        return _point_data, freesurfer.write_scalars
    return freesurfer.read_scalars, freesurfer.write_scalars


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
    >>> from igl_spheremap.io import read_landmarks
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
