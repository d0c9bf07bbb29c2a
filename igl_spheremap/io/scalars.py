"""Scalar maps over the vertices: GIFTI, FreeSurfer's curvature files, NPZ."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import FileError, MeshError
from . import freesurfer, gifti, npz
from .records import Metadata
from .replacing import replacing

FloatArray = NDArray[np.float64]
_HEMISPHERES = ("lh.", "rh.")


def read_scalars(path: str | os.PathLike[str]) -> dict[str, FloatArray]:
    """Read scalar maps over the vertices of a mesh.

    Parameters
    ----------
    path : str or path-like
        A .gii file, an .npz file with arrays of one dimension, or else a curvature file of FreeSurfer.

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
    name = source.name.lower()
    try:
        if name.endswith(gifti.FORMAT.suffixes):
            maps = gifti.read_scalars(source)
        elif name.endswith(".npz"):
            with np.load(source, allow_pickle=False) as archive:
                maps = {key: archive[key].astype(np.float64) for key in archive if archive[key].ndim == 1}
        else:
            maps = freesurfer.read_scalars(source)
    except FileError:
        raise
    except OSError as error:
        raise FileError(f"can't read {path}: {error.strerror or error}") from error
    except Exception as error:  # third-party parsers raise anything on damaged files
        raise MeshError(f"{path}: damaged, or no scalar map ({' '.join(str(error).split())[:120]})") from error
    if not maps:
        raise MeshError(f"{path} holds no scalar map: no array has one number a vertex")
    return maps


def write_scalars(
    path: str | os.PathLike[str],
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

    Returns
    -------
    None

    Raises
    ------
    FileError
        If the format is another one, the file exists and `force` is not set, or writing fails.
    """
    target, told = Path(path), metadata or {}
    name = target.name.lower()
    if not name.endswith((*gifti.FORMAT.suffixes, ".npz")) and not name.startswith(_HEMISPHERES):
        raise FileError(f"{path}: scalar maps are written to .gii, .npz, and lh.NAME or rh.NAME files")
    with replacing(path, force) as partial:
        if name.endswith(gifti.FORMAT.suffixes):
            gifti.write_scalars(partial, dict(maps), told)
        elif name.endswith(".npz"):
            npz.write_arrays(partial, dict(maps))
        elif len(maps) == 1:
            freesurfer.write_scalars(partial, dict(maps), told)
        else:
            raise FileError(f"{path}: FreeSurfer's files hold one map, not {len(maps)}: {', '.join(maps)}")
