"""Scalar maps over the vertices: GIFTI, FreeSurfer's curvature files, NPZ."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import FileError
from . import freesurfer, gifti, npz
from .records import Metadata
from .replacing import replacing

FloatArray = NDArray[np.float64]
_HEMISPHERES = ("lh.", "rh.")


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
