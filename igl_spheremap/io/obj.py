"""Wavefront OBJ. Positions and faces are read; texture coordinates, normals and groups are passed over.

libigl's reader gives up on a ``nan``, cuts polygons into triangles unasked and takes any index, and its
writers report success on a full disk: text files are therefore read and written here.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .polygons import Polygons
from .records import FloatArray, Format, IntArray, Metadata, RawMesh
from .text import indices, numbers, read_text, write_rows


def read(path: Path) -> RawMesh:
    """Read an OBJ file.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    RawMesh
        Positions and faces, 0-based.

    Raises
    ------
    MeshError
        If a vertex or face can't be made sense of.
    """
    data = read_text(path)
    if b"\\" in data:
        data = re.sub(rb"\\\r?\n", b" ", data)
    if b"#" in data:
        data = re.sub(rb"#[^\r\n]*", b"", data)
    if re.search(rb"^[ \t]", data, re.MULTILINE):
        data = re.sub(rb"(?m)^[ \t]+", b"", data)
    lines = data.splitlines()
    v = numbers([line[2:].split() for line in lines if line.startswith((b"v ", b"v\t"))], 3, "vertex")
    face_lines = [line[2:] for line in lines if line.startswith((b"f ", b"f\t"))]
    if b"/" in data:
        face_lines = re.sub(rb"/[^ \t\n]*", b"", b"\n".join(face_lines)).split(b"\n") if face_lines else []
    faces = indices([line.split() for line in face_lines])
    if (faces.corners < 0).any():
        faces = _absolute(faces, lines)
    return RawMesh(v, Polygons(faces.corners - 1, faces.sizes))


def _absolute(faces: Polygons, lines: list[bytes]) -> Polygons:
    """Negative indices counted back from the vertices that stand above the face."""
    is_face = np.array([line.startswith((b"f ", b"f\t")) for line in lines])
    above = np.cumsum([line.startswith((b"v ", b"v\t")) for line in lines])[is_face]
    counted: NDArray[np.int64] = faces.corners + np.repeat(above, faces.sizes) + 1
    return Polygons(np.where(faces.corners < 0, counted, faces.corners), faces.sizes)


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write an OBJ file with all digits.

    Parameters
    ----------
    path : Path
        The file.
    v : (n, 3) float64 array
        Positions.
    f : (m, 3) int64 array
        Faces.
    metadata : dict
        Nothing of it can be kept.

    Returns
    -------
    None
    """
    with path.open("wb") as file:
        write_rows(file, "v %r %r %r\n", v)
        write_rows(file, "f %r %r %r\n", f + 1)


FORMAT = Format("OBJ", (".obj",), read, write)
