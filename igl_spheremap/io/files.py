"""Meshes from files and to files."""

from __future__ import annotations

from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from .. import samples
from ..errors import own_errstate
from ..mesh.arrays import check_rows, check_triangles
from ..mesh.objects import MeshLike, vertices_and_faces
from .formats import PathLike, format_of
from .gifti import structure_of
from .reading import reading
from .records import LoadedMesh, Metadata, RawMesh
from .replacing import replacing

#: What names of samples begin with.
SAMPLE = "sample:"


@own_errstate
def read_mesh(path: PathLike, *, triangulate: bool = False) -> LoadedMesh:
    """Read a triangle mesh; the end of the file's name, or else its first bytes, decide its format.

    Parameters
    ----------
    path : str or path-like
        An OBJ, OFF, PLY, STL, VTK, glTF, GIFTI, FreeSurfer or NPZ file, or a shape model of a small body; or
        ``sample:NAME[:key=value,...]``, a shape of `igl_spheremap.samples`.
    triangulate : bool
        Cut polygons into triangles; by default they are refused.

    Returns
    -------
    LoadedMesh
        Unpacks to ``v, f``, both unchecked; ``metadata`` holds what `write_mesh` can keep.

    Raises
    ------
    FileError
        If the file can't be opened or is not a regular file, its format is unknown, or the package that reads it is not
        installed.
    MeshError
        If it is damaged, empty or not a triangle mesh, or would expand to far more memory than its size.
    ValueError
        If there is no such sample.

    Examples
    --------
    >>> import tempfile
    >>> import igl_spheremap as ism
    >>> ism.read_mesh("sample:sphere:n_vertices=42")
    LoadedMesh(42 vertices, 80 faces)
    >>> v, f = ism.samples.sphere(42)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     ism.write_mesh(f"{folder}/ball.off", v, f)
    ...     w, g = ism.read_mesh(f"{folder}/ball.off")
    >>> bool((v == w).all()), bool((f == g).all())
    (True, True)
    """
    return _read(path, triangulate=triangulate)


def read_sphere(path: PathLike) -> LoadedMesh:
    """Read the image of a map: the sphere of an NPZ or PLY file that holds both surfaces, the mesh of any other file.

    Parameters
    ----------
    path : str or path-like
        As for `read_mesh`.

    Returns
    -------
    LoadedMesh
        Unpacks to ``x, f``; the radius is as stored.

    Raises
    ------
    FileError, MeshError
        As from `read_mesh`.
    """
    return _read(path, sphere=True)


def _read(path: PathLike, sphere: bool = False, triangulate: bool = False) -> LoadedMesh:
    """Read a file or make a sample; the sphere, if it is asked for, of a file that holds a map."""
    if str(path).startswith(SAMPLE):
        return LoadedMesh(*samples.from_spec(str(path).removeprefix(SAMPLE)))
    path = Path(path)
    with reading(path):
        raw: RawMesh = format_of(path).functions.read(path)
        positions = raw.sphere if sphere and raw.sphere is not None else raw.v
        v, f = check_rows(positions, name="vertices"), raw.faces.triangles(triangulate)
        return LoadedMesh(v, f, structure_of(path) | dict(raw.metadata), int(np.count_nonzero(raw.faces.sizes > 3)))


@own_errstate
def write_mesh(
    path: PathLike, v: ArrayLike | MeshLike, f: ArrayLike | None = None, *, force: bool = False,
    metadata: Metadata | None = None,
) -> None:
    """Write a triangle mesh; the end of the file's name decides the format.

    The file is written under a temporary name and renamed. OBJ, OFF, PLY, VTK, NPZ and .tab are exact; STL, glTF, GIFTI
    and FreeSurfer files hold float32. STL files hold no vertices, but triangles: the order of the vertices is lost.

    Parameters
    ----------
    path : str or path-like
        The new file.
    v : (n, 3) array_like
        Vertex positions, any units; or a mesh object, which needs no `f`.
    f : (m, 3) array_like
        0-based faces.
    force : bool
        Replace an existing file.
    metadata : dict, optional
        As `read_mesh` gave it; nothing by default.

    Raises
    ------
    FileError
        If the file exists and `force` is not set, or it can't be written; nothing is left behind.
    MeshError
        If the arrays are not of that shape.

    Examples
    --------
    >>> import os, tempfile
    >>> import igl_spheremap as ism
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     ism.write_mesh(f"{folder}/ball.ply", *ism.samples.sphere(42))
    ...     os.listdir(folder)
    ['ball.ply']
    """
    rows, triangles = vertices_and_faces(v) if f is None else (cast(ArrayLike, v), f)
    x, faces = check_rows(rows, name="vertices"), check_triangles(triangles)
    kind = format_of(path)
    with replacing(path, force) as partial:
        known = {"name": Path(path).stem} | structure_of(path) | dict(metadata or {})
        kind.functions.write(partial, x, faces, known)
