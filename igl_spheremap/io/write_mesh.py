"""Meshes to files."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError
from ..gate import MeshLike, PathLike, gate
from ..mesh.arrays import FloatArray, check_rows, check_triangles
from .formats import format_of
from .hemispheres import structure_of
from .objects import vertices_and_faces
from .records import Metadata
from .replacing import replacing


@gate
def write_mesh(
    path: PathLike,
    v: ArrayLike | MeshLike,
    f: ArrayLike | None = None,
    *,
    force: bool = False,
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
    if f is None:
        v, f = vertices_and_faces(v)
    x, faces = check_rows(cast(ArrayLike, v), name="vertices"), check_triangles(f)
    kind = format_of(path)
    if kind.single:
        _check_single(path, x)
    with replacing(path, force) as partial:
        kind.functions.write(partial, x, faces, kept_of(path, metadata))


def kept_of(path: PathLike, metadata: Metadata | None, **more: str) -> dict[str, Any]:
    """Data that a writer can keep: the metadata, or else the facts in the file's name."""
    return {"name": Path(path).stem} | more | structure_of(path) | dict(metadata or {})


def _check_single(path: PathLike, x: FloatArray) -> None:
    """Refuse positions that float32 does not hold: beyond its range, or so small that digits are lost."""
    size = np.abs(x[np.isfinite(x)]).max(initial=0.0)
    with np.errstate(over="ignore", invalid="ignore"):
        off = np.abs(x.astype(np.float32) - x)
    if (off > np.finfo(np.float32).eps * size).any():
        raise MeshError(
            f"{path} holds float32, which can't hold positions of size {size:.2g}; scale the mesh, or write .ply"
        )
