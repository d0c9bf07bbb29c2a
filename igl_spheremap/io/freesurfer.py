"""FreeSurfer geometry (lh.pial, lh.sphere, ...) and its scalar maps (lh.curv), by nibabel; float32."""

from __future__ import annotations

import errno
import os
import struct
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ..errors import FileError, MeshError, import_optional
from ..mesh.arrays import FloatArray, IntArray
from .reading import check_complete
from .records import Metadata, RawMesh, of_triangles
from .text import indices, numbers, read_rows

_TRIANGLES = b"\xff\xff\xfe"
#: How the geometry of the volume begins, behind the triangles.
_VOLUMES = struct.pack(">i", 20), struct.pack(">iii", 2, 0, 20)
#: How curvature files begin, and files of quads.
CURVATURE = b"\xff\xff\xff"


def read(path: Path) -> RawMesh:
    """A surface in its own coordinates, with the geometry of its volume; as text, too, as mris_convert writes .asc."""
    if path.read_bytes().startswith(b"#!ascii"):
        return _read_text(path)
    freesurfer = import_optional("nibabel.freesurfer", "FreeSurfer geometry", "io")
    volume = b""
    with path.open("rb") as file:
        if file.read(3) == _TRIANGLES:
            file.readline()
            file.readline()
            announced = struct.unpack(">ii", file.read(8))
            _check_size(file, 12, *announced)
            file.seek(12 * sum(announced), os.SEEK_CUR)
            volume = file.read(12)
    if not volume.startswith(_VOLUMES):  # nibabel would warn
        v, f = freesurfer.read_geometry(path)
        return RawMesh(v, of_triangles(f))
    v, f, geometry = freesurfer.read_geometry(path, read_metadata=True)
    return RawMesh(v, of_triangles(f), {"volume": dict(geometry)})


def _read_text(path: Path) -> RawMesh:
    """Counts, positions and triangles, each with a number behind it."""
    rows = read_rows(path.read_bytes())
    check_complete(len(rows) > 0 and int(rows.counts[0]) == 2, "no counts", "two of them")
    n, m = indices(rows[:1]).corners.tolist()
    check_complete(0 <= n <= n + m == len(rows) - 1, f"{len(rows) - 1} lines", f"{n} and {m}")
    faces = numbers(rows[n + 1 :], 3, "face")
    return RawMesh(numbers(rows[1 : n + 1], 3, "vertex"), of_triangles(faces.astype(np.int64)))


def _check_size(file: BinaryIO, size: int, *announced: int) -> None:
    """Refuse counts of rows that a file can't hold: nibabel takes memory for as many as are announced."""
    rest = os.fstat(file.fileno()).st_size - file.tell()
    fit = min(announced) >= 0 and size * sum(announced) <= rest
    check_complete(fit, f"{rest} bytes", f"{' and '.join(map(str, announced))} rows")


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write a surface in float32, with the mark as its comment; ``volume`` is kept."""
    freesurfer = import_optional("nibabel.freesurfer", "FreeSurfer geometry", "io")
    comment = metadata.get("mark", "created by igl_spheremap")
    freesurfer.write_geometry(path, v, f, create_stamp=comment, volume_info=metadata.get("volume"))
    _check_whole(path, 13 + len(comment) + 12 * (len(v) + len(f)))


def read_scalars(path: Path) -> dict[str, NDArray[Any]]:
    """A curvature file's scalar map, named by the file's suffix."""
    freesurfer = import_optional("nibabel.freesurfer", "FreeSurfer data", "io")
    with path.open("rb") as file:
        if file.read(3) != CURVATURE:
            raise MeshError(
                "the file holds no data over vertices; give a curvature file, such as lh.thickness"
            )
        _check_size(file, 4, int.from_bytes(file.read(4), "big", signed=True))
    return {path.name.rpartition(".")[2]: freesurfer.read_morph_data(path)}


def write_scalars(path: Path, maps: dict[str, FloatArray], metadata: Metadata) -> None:
    """Write one scalar map as FreeSurfer's curvature files are, in float32; no metadata can be kept."""
    _, values = only(maps)
    import_optional("nibabel.freesurfer", "FreeSurfer data", "io").write_morph_data(path, values)
    _check_whole(path, 15 + 4 * len(values))


def only(maps: dict[str, FloatArray]) -> tuple[str, FloatArray]:
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
