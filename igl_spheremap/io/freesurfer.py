"""FreeSurfer geometry (lh.pial, lh.sphere, ...) and its scalar maps (lh.curv), by nibabel; float32."""

from __future__ import annotations

import errno
import os
import struct
from pathlib import Path

import numpy as np

from ..errors import FileError, MeshError, import_optional
from ..mesh.arrays import FloatArray, IntArray
from .reading import Bytes, check_complete
from .records import Metadata, NamedArrays, RawMesh, ScalarMaps, of_triangles
from .text import indices, numbers, read_rows

_TRIANGLES = b"\xff\xff\xfe"
#: Beginning of the geometry of the volume, behind the triangles.
_VOLUMES = struct.pack(">i", 20), struct.pack(">iii", 2, 0, 20)
#: Beginnings of curvature files, and files of quads.
CURVATURE = b"\xff\xff\xff"


def read(path: Path) -> RawMesh:
    """A surface in its own coordinates, with the geometry of its volume; as text, too, as mris_convert writes .asc."""
    data = path.read_bytes()
    if data.startswith(b"#!ascii"):
        return _read_text(data)
    freesurfer = import_optional("nibabel.freesurfer", "FreeSurfer geometry", "io")
    volume = b""
    if data.startswith(_TRIANGLES):
        file = Bytes(data, data.index(b"\n", data.index(b"\n") + 1) + 1)
        n, m = file.array(">i4", 2).tolist()
        # nibabel takes memory for as many rows as are announced
        file.take(12 * n)
        file.take(12 * m)
        volume = data[file.at : file.at + 12]
    if not volume.startswith(_VOLUMES):  # nibabel would warn
        v, f = freesurfer.read_geometry(path)
        return RawMesh(v, of_triangles(f))
    v, f, geometry = freesurfer.read_geometry(path, read_metadata=True)
    return RawMesh(v, of_triangles(f), {"volume": dict(geometry)})


def _read_text(data: bytes) -> RawMesh:
    """Counts, positions and triangles, each with a number behind it."""
    rows = read_rows(data)
    check_complete(len(rows) > 0 and int(rows.counts[0]) == 2, "no counts", "two of them")
    n, m = indices(rows[:1]).corners.tolist()
    check_complete(0 <= n <= n + m == len(rows) - 1, f"{len(rows) - 1} lines", f"{n} and {m}")
    faces = numbers(rows[n + 1 :], 3, "face")
    return RawMesh(numbers(rows[1 : n + 1], 3, "vertex"), of_triangles(faces.astype(np.int64)))


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write a surface in float32, with the mark as its comment; ``volume`` is kept."""
    freesurfer = import_optional("nibabel.freesurfer", "FreeSurfer geometry", "io")
    comment = metadata.get("mark", "created by igl_spheremap")
    freesurfer.write_geometry(path, v, f, create_stamp=comment, volume_info=metadata.get("volume"))
    _check_whole(path, 13 + len(comment) + 12 * (len(v) + len(f)))


def read_scalars(path: Path) -> NamedArrays:
    """A curvature file's scalar map, named by the file's suffix."""
    freesurfer = import_optional("nibabel.freesurfer", "FreeSurfer data", "io")
    data = path.read_bytes()
    if not data.startswith(CURVATURE):
        raise MeshError(
            "the file holds no data over vertices; give a curvature file, such as lh.thickness"
        )
    file = Bytes(data, len(CURVATURE))
    file.take(4 * file.number(">i4"))
    return {path.name.rpartition(".")[2]: freesurfer.read_morph_data(path)}


def write_scalars(path: Path, maps: ScalarMaps, metadata: Metadata) -> None:
    """Write one scalar map as FreeSurfer's curvature files are, in float32; no metadata can be kept."""
    _, values = only(maps)
    import_optional("nibabel.freesurfer", "FreeSurfer data", "io").write_morph_data(path, values)
    _check_whole(path, 15 + 4 * len(values))


def only(maps: ScalarMaps) -> tuple[str, FloatArray]:
    """Name and values of the one map that FreeSurfer's files hold."""
    if len(maps) != 1:
        raise FileError(
            f"FreeSurfer's files hold one map, not {len(maps)}: {', '.join(maps)}; choose one"
        )
    return next(iter(maps.items()))


def _check_whole(path: Path, size: int) -> None:
    """Raise an OSError if the file is too short: numpy.tofile, by which nibabel writes, does not report a full disk."""
    if path.stat().st_size < size:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
