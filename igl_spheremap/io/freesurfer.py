"""FreeSurfer geometry (lh.pial, lh.sphere, ...) and its scalar maps (lh.curv), by nibabel; float32."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from ..errors import import_optional
from .polygons import of_triangles
from .records import FloatArray, Format, IntArray, Metadata, RawMesh

#: Kinds of surfaces, as FreeSurfer names them: lh.pial, rh.white, ...
_KINDS = (
    "pial",
    "white",
    "sphere",
    "inflated",
    "smoothwm",
    "orig",
    "midthickness",
    "graymid",
    "qsphere",
    "reg",
    "surf",
)


def read(path: Path) -> RawMesh:
    """Read a FreeSurfer surface, with the geometry of its volume.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    RawMesh
        Positions in surface coordinates, and faces.

    Raises
    ------
    FileError
        If nibabel is not installed.
    """
    freesurfer = import_optional("nibabel.freesurfer", "FreeSurfer geometry", "io")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # files without the volume's geometry are in order
        v, f, volume = freesurfer.read_geometry(path, read_metadata=True)
    metadata = {"volume": dict(volume)} if volume and "volume" in volume else {}
    return RawMesh(np.array(v, dtype=np.float64), of_triangles(f), metadata)


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write a FreeSurfer surface in float32.

    Parameters
    ----------
    path : Path
        The file.
    v : (n, 3) float64 array
        Positions.
    f : (m, 3) int64 array
        Faces.
    metadata : dict
        ``volume`` is kept.

    Returns
    -------
    None
    """
    freesurfer = import_optional("nibabel.freesurfer", "FreeSurfer geometry", "io")
    freesurfer.write_geometry(
        path, v, f, create_stamp="created by igl_spheremap", volume_info=metadata.get("volume")
    )


def read_scalars(path: Path) -> dict[str, FloatArray]:
    """A curvature file's map, by the end of the file's name."""
    freesurfer = import_optional("nibabel.freesurfer", "FreeSurfer data", "io")
    return {path.name.rpartition(".")[2]: np.array(freesurfer.read_morph_data(path), dtype=np.float64)}


def write_scalars(path: Path, maps: dict[str, FloatArray], metadata: Metadata) -> None:
    """Write one scalar map as FreeSurfer's curvature files are, in float32.

    Parameters
    ----------
    path : Path
        The file.
    maps : dict of one (n,) float64 array
        Values at the vertices.
    metadata : dict
        Nothing of it can be kept.

    Returns
    -------
    None
    """
    (values,) = maps.values()
    import_optional("nibabel.freesurfer", "FreeSurfer data", "io").write_morph_data(path, values)


FORMAT = Format(
    "FreeSurfer",
    tuple(f".{kind}" for kind in _KINDS),
    read,
    write,
    magic=(b"\xff\xff\xfe", b"\xff\xff\xff"),
    radius=100.0,
    single=True,
)
