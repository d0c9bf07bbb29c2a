"""OBJ files: positions and faces; other contents are left out. MNI's files of that name (CIVET, MINC), too.

libigl's reader gives up on a ``nan``, cuts polygons into triangles unasked and takes any index; its writer reports
success on a full disk.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import MeshError
from ..mesh.arrays import AnyArray, FloatArray, IntArray
from ..mesh_repair.polygons import cut_polygons
from .reading import check_complete
from .records import Metadata, Polygons, RawMesh, ending
from .text import indices, numbers, read_rows, write_text


def read(path: Path) -> RawMesh:
    """The positions and faces of an OBJ file."""
    data = path.read_bytes()
    if data.startswith((b"P ", b"P\t")):
        return _mni(data)
    if data.startswith(b"p") and b"\0" in data[:64]:
        raise MeshError("a binary MNI object, which is not read; let its program write it as text")
    if b"\\" in data:
        data = re.sub(rb"\\\r?\n", b" ", data)
    rows = read_rows(data)
    vertices, face_rows = rows.starting_with(b"v"), rows.starting_with(b"f")
    v, faces = numbers(vertices, 3, "vertex"), indices(face_rows)
    # Negative indices count back from the vertices that stand above the face.
    above = np.repeat(np.searchsorted(vertices.begin, face_rows.begin), faces.sizes)
    corners = np.where(faces.corners < 0, faces.corners + above, faces.corners - 1)
    return RawMesh(v, Polygons(corners, faces.sizes))


def _mni(data: bytes) -> RawMesh:
    """The polygons of an MNI object as text.

    Behind a P: 5 numbers of its look, points and as many normals; the number of polygons, whether there is one colour
    (0), one a polygon (1) or one a point (2), and the colours; the ends of polygons among the corners, and the corners.
    """
    words = np.array(data[1:].split())

    def taken(count: int, kind: type) -> AnyArray:
        nonlocal words
        check_complete(0 <= count <= len(words), f"{len(words)} numbers", str(count))
        part: AnyArray = words[:count].astype(kind)
        words = words[count:]
        return part

    taken(5, float)
    n = int(taken(1, int)[0])
    v = taken(3 * n, float).reshape(-1, 3)
    taken(3 * n, float)
    m, colours = taken(2, int).tolist()
    taken(4 * {0: 1, 1: m, 2: n}[colours], float)
    ends = taken(m, int)
    check_complete(m > 0, "no polygons", "polygons")
    return RawMesh(v, ending(taken(int(ends[-1]), int), ends))


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write all digits, and the mark as a comment."""
    write_text(path, "", metadata, ("v %r %r %r\n", v), ("f %r %r %r\n", f + 1))


@dataclass(frozen=True, eq=False)
class ObjTexture:
    """Texture coordinates (k, 2), and for each corner (m, 3) of the triangles its vertex and its row of these."""

    uv: FloatArray
    vertex: IntArray
    row: IntArray


def texture(data: bytes) -> ObjTexture | None:
    """The texture coordinates of an OBJ file; None if it has none."""
    rows = read_rows(data)
    uv = rows.starting_with(b"vt")
    if not len(uv):
        return None
    faces = rows.starting_with(b"f")
    text = faces.bytes()
    pairs = re.findall(rb"(?<!\S)(\d+)/(\d+)(?=[/\s])", text)
    if len(pairs) != len(text.split()):
        raise MeshError(
            "faces without texture coordinates, or with negative numbers; write it anew"
        )
    vertex, row = np.array(pairs, dtype=np.int64).T - 1
    if min(vertex.min(), row.min()) < 0 or row.max() >= len(uv):
        raise MeshError(
            f"faces name texture coordinates beyond the {len(uv)} that it has; write it anew"
        )
    if faces.counts.min() < 3:
        raise MeshError("faces of less than three corners; remove them")
    v = numbers(rows.starting_with(b"v"), 3, "vertex")
    triangles = cut_polygons(v, vertex, faces.counts).triangles
    return ObjTexture(numbers(uv, 2, "texture coordinate"), vertex[triangles], row[triangles])
