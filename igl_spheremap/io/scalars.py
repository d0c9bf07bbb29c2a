"""Maps over the vertices, of numbers or of labels, in files of many formats; and lists of vertices."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ..errors import FileError, MeshError, printable
from ..gate import PathLike, gate
from ..mesh.arrays import FloatArray, IntArray
from .formats import format_in, format_of
from .npz import LABEL_TABLE
from .reading import read_lines, reading
from .records import LabelTable, Metadata, ScalarMaps
from .replacing import replacing
from .write_mesh import write_mesh


@gate
def read_scalars(path: PathLike, *, structure: str | None = None) -> ScalarMaps:
    """Read scalar maps over the vertices of a mesh.

    Parameters
    ----------
    path : str or path-like
        A .gii or .annot file; an .npz file with arrays of one dimension; an .npy file; a table (.csv, .tsv, .txt, .1D),
        whose columns without a header are called 0, 1, ...; a .ply file with properties of vertices; a .vtk file with
        point data; a CIFTI file (.dscalar.nii, .dlabel.nii, .dtseries.nii); or a curvature file of FreeSurfer, known by
        its first bytes.
    structure : str, optional
        The structure of a CIFTI file to read, such as "CortexLeft"; by default the only one. Vertices without data,
        those of the medial wall, are NaN.

    Returns
    -------
    dict of (n,) float64 arrays
        Values by name; of labels their keys, which `read_labels` explains.

    Raises
    ------
    FileError
        If the file can't be opened, its format is unknown, or the package that reads it is not installed.
    MeshError
        If it is damaged or holds no scalar map.

    See Also
    --------
    write_scalars : the other way.

    Examples
    --------
    >>> import os, tempfile
    >>> import igl_spheremap as ism
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = os.path.join(folder, "heights.csv")
    ...     ism.write_scalars(path, {"height": np.array([0.5, 1.0])})
    ...     ism.read_scalars(path)
    {'height': array([0.5, 1. ])}
    """
    source = Path(path)
    with reading(source):
        kind = format_in(source, data=True)
        if kind.sides:
            found = kind.functions.read_scalars(source, structure)
        elif hasattr(kind.functions, "read_scalars"):
            found = kind.functions.read_scalars(source)
        else:
            found = kind.functions.read(source).metadata.get("point_data", {})
        maps = {
            printable(name): values.astype(np.float64)
            for name, values in found.items()
            if values.ndim == 1 and values.dtype.kind in "fiub"
        }
        if not maps:
            raise MeshError("the file holds no scalar map; give arrays of one number a vertex")
        return maps


def file_of(path: str) -> tuple[str, str]:
    """The file of FILE:NAME, and the name, which is empty for a file.

    >>> file_of("thickness.csv:mean"), file_of("thickness.csv")
    (('thickness.csv', 'mean'), ('thickness.csv', ''))
    """
    file, colon, name = path.rpartition(":")
    if not colon or Path(path).exists():
        return path, ""
    return file, name


def read_named(path: str, structure: str | None = None) -> ScalarMaps:
    """The maps of a file as `read_scalars` gives them, or the one of FILE:NAME."""
    file, name = file_of(path)
    maps = read_scalars(file, structure=structure)
    if not name:
        return maps
    if name not in maps:
        raise MeshError(f"{file} holds no map {name!r}; it has {', '.join(maps)}")
    return {name: maps[name]}


def read_labels(path: PathLike) -> LabelTable | None:
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
        functions = format_in(source, data=True).functions
        if not hasattr(functions, "read_table"):
            return None
        table: LabelTable | None = functions.read_table(source)
        return table


@gate
def write_scalars(
    path: PathLike,
    maps: Mapping[str, FloatArray],
    *,
    surface: tuple[FloatArray, IntArray] | None = None,
    force: bool = False,
    metadata: Metadata | None = None,
) -> None:
    """Write scalar maps over the vertices of a mesh.

    Parameters
    ----------
    path : str or path-like
        The new file: .gii (one data array each, float32), .annot (one map of labels), .npz, .npy, .csv and .tsv (with a
        header), .txt and .1D (without), .ply or .vtk, a CIFTI file (.dscalar.nii, .dlabel.nii, .dtseries.nii; float32;
        NaN stands for no data); or another name that starts with lh. or rh. (one map, as FreeSurfer writes curvature,
        float32).
    maps : dict of (n,) arrays
        Values by name.
    surface : (v, f), optional
        Positions and faces, which .ply and .vtk files hold with the data.
    force : bool
        Replace an existing file.
    metadata : dict, optional
        As `read_mesh` gave it for the surface; nothing by default. With ``labels``, a table as `read_labels` gives it,
        the values are labels: whole numbers (int32 in .gii and CIFTI files), and the table is written, too. An .annot
        file renumbers labels by their places in the table. A CIFTI file needs the ``structure``, and holds the maps of
        ``others``, too, by their structures.

    Raises
    ------
    MeshError
        If labels are not whole numbers, or of an .annot file have no table or not each a colour of its own.
    FileError
        If the format is another one, the file exists and `force` is not set, or writing fails.

    See Also
    --------
    read_scalars : the other way, with an example.
    """
    kind, known, kept = format_of(path, data=True), dict(metadata or {}), dict(maps)
    taken = [""]
    if "labels" in known:
        taken.append(LABEL_TABLE)
    for name in kept:
        if name in taken or printable(name).strip() != name:
            raise FileError(
                f"{path}: no map can be called {name!r}; give it a name of one line that nothing else has"
            )
    if "labels" in known:
        for name, values in kept.items():
            if kind.sides:
                values = values[~np.isnan(values)]
            if not (np.abs(values) < 2**31).all() or (values != np.floor(values)).any():
                raise MeshError(f"{name} holds no labels; give whole numbers of at most 32 bits")
    if hasattr(kind.functions, "write_scalars"):
        with replacing(path, force) as partial:
            kind.functions.write_scalars(partial, kept, known)
        return
    if surface is None:
        raise FileError(
            f"{path}: such a file holds data with their surface; give it as `surface=(v, f)`"
        )
    if "labels" in known:
        kept = {name: values.astype(np.int32) for name, values in kept.items()}
    known |= {"vertex_properties": kept, "point_data": kept}
    write_mesh(path, *surface, force=force, metadata=known)


def read_landmarks(path: PathLike) -> IntArray:
    """Read a list of landmarks: vertices, each of which corresponds to the vertex in the same line of another list.

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
        if words[:1] == ["lk"]:
            words.pop(0)
        if not words:
            continue
        if len(words) not in (1, 4) or not re.fullmatch("[0-9]{1,18}", words[0]):
            raise FileError(
                f"{path}, line {number}: give a vertex, from 0, and nothing or its position behind it"
            )
        vertices.append(int(words[0]))
    if not vertices:
        raise FileError(f"{path} has no landmarks; give one vertex a line")
    return np.array(vertices, dtype=np.int64)
