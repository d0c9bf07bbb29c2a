"""Meshes from files and to files."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ..errors import FileError, MeshError
from ..mesh.check import check_rows
from . import npz
from .formats import format_of
from .records import LoadedMesh, Metadata, RawMesh
from .replacing import replacing

PathLike = str | os.PathLike[str]


def read_mesh(path: PathLike, *, triangulate: bool = False) -> LoadedMesh:
    """Read a triangle mesh; the end of the file's name, or else its first bytes, tell the format.

    Parameters
    ----------
    path : str or path-like
        An OBJ, OFF, PLY, STL, glTF, GIFTI, FreeSurfer or NPZ file.
    triangulate : bool
        Cut polygons into triangles; by default they are refused.

    Returns
    -------
    LoadedMesh
        Unpacks to ``v, f``, both unchecked; ``metadata`` holds what `write_mesh` can keep.

    Raises
    ------
    FileError
        If the file can't be opened, its format is unknown, or the package that reads it is not installed.
    MeshError
        If it is damaged, empty or no triangle mesh.

    Examples
    --------
    >>> import os, tempfile
    >>> import igl_spheremap as ism
    >>> from igl_spheremap.io import read_mesh, write_mesh
    >>> v, f = ism.samples.sphere(42)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_mesh(os.path.join(folder, "ball.off"), v, f)
    ...     w, g = read_mesh(os.path.join(folder, "ball.off"))
    >>> np.array_equal(v, w), np.array_equal(f, g)
    (True, True)
    """
    raw = _read_raw(Path(path))
    try:
        return LoadedMesh(
            raw.v, raw.faces.triangles(triangulate), raw.metadata, int(np.count_nonzero(raw.faces.sizes > 3))
        )
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from None


def read_sphere(path: PathLike) -> LoadedMesh:
    """Read a map's image: of an NPZ file that holds a map the sphere, of any other file the mesh.

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
    mesh = read_mesh(path)
    if format_of(path) is npz.FORMAT:
        with np.load(path, allow_pickle=False) as archive:
            if "sphere" in archive:
                return LoadedMesh(archive["sphere"], mesh.f, mesh.metadata)
    return mesh


def write_mesh(
    path: PathLike, v: ArrayLike, f: ArrayLike, *, force: bool = False, metadata: Metadata | None = None
) -> None:
    """Write a triangle mesh; the end of the file's name tells the format.

    The file is written under a temporary name and renamed. OBJ, OFF, PLY and NPZ are exact; STL, glTF, GIFTI
    and FreeSurfer files hold float32.

    Parameters
    ----------
    path : str or path-like
        The new file.
    v : (n, 3) array_like
        Positions.
    f : (m, 3) array_like
        0-based faces.
    force : bool
        Replace an existing file.
    metadata : dict, optional
        As `read_mesh` gave it; nothing by default.

    Returns
    -------
    None

    Raises
    ------
    FileError
        If the file exists and `force` is not set, or it can't be written; nothing is left behind.
    MeshError
        If the arrays are not of that shape.
    """
    x = check_rows(v, name="vertices")
    faces = np.ascontiguousarray(np.asarray(f, dtype=np.int64).reshape(-1, 3))
    kind = format_of(path)
    with replacing(path, force) as partial:
        kind.write(partial, x, faces, metadata or {})


def _read_raw(path: Path) -> RawMesh:
    """The file's content, with every way in which a reader may fail turned into one line."""
    try:
        if path.is_dir():
            raise FileError(f"can't read {path}: it is a directory")
        if path.stat().st_size == 0 and path.is_file():
            raise MeshError("the file is empty (0 bytes); give a closed triangle mesh")
        return format_of(path).read(path)
    except FileError:
        raise
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from None
    except OSError as error:
        if error.strerror is None:  # a parser's complaint, not the system's
            raise _damaged(path, error) from error
        raise FileError(f"can't read {path}: {error.strerror}") from error
    except Exception as error:  # third-party parsers raise anything on damaged files
        raise _damaged(path, error) from error


def _damaged(path: Path, error: Exception) -> MeshError:
    reason = " ".join(str(error).split())[:120] or type(error).__name__
    return MeshError(f"{path}: damaged, or no {format_of(path).name} file ({reason}); write it anew")
