"""Shape models of comets and asteroids as text: tables of plates of the Planetary Data System (.tab), .ver, and ICQ."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import MeshError
from ..mesh.arrays import FloatArray, IntArray
from . import obj
from .reading import check_complete
from .records import Metadata, RawMesh, of_triangles
from .text import indices, numbers, read_rows, write_text


def read(path: Path) -> RawMesh:
    """A table of vertices and one of plates, each with or without numbers; lines of OBJ; or the grids of ICQ.

    The counts stand in the first line, or each before its table. In .ver files a line before each plate has the number
    of its corners. Plates count from the number of the first vertex, or else from 1 unless one has a corner 0.
    """
    rows = read_rows(path.read_bytes())
    if len(rows) and len(rows[:1].starting_with(b"v")):
        return obj.read(path)
    n, *more = indices(rows[:1]).corners.tolist() or [0]
    if not more and len(rows) == 1 + 6 * (n + 1) ** 2:
        return _icq(numbers(rows[1:], 3, "vertex"), n)
    check_complete(
        0 < n < len(rows) - 1, f"{len(rows) - 1} lines", f"{n} vertices and their plates"
    )
    v = numbers(rows[1 : n + 1], int(rows.counts[1]), "vertex")
    rest = rows[n + 1 :]
    if not more:
        more, rest = indices(rest[:1]).corners.tolist(), rest[1:]
    m = more[0]
    plates = rest[:m]
    if len(rest) == 2 * m:
        plates = rest[1::2]
    check_complete(0 < m == len(plates), f"{len(rest)} lines", f"{m} plates")
    corners = indices(plates).corners.reshape(m, -1)[:, -3:]
    first = int(corners.min() > 0)
    if v.shape[1] == 4:
        first = int(v[0, 0])
    return RawMesh(v[:, -3:], of_triangles(corners - first))


def _icq(points: FloatArray, q: int) -> RawMesh:
    """Six grids (q + 1)^2, those of the faces of a cube; each square becomes two triangles, in its direction."""
    j, i = np.indices((q + 1, q + 1))
    o, e = 0 * i, q + 0 * i
    cube = np.array(
        [
            (i, j, e),
            (i, e, q - j),
            (o, i, q - j),
            (q - i, o, q - j),
            (e, q - i, q - j),
            (i, q - j, o),
        ]
    )
    place = np.moveaxis(cube, 1, -1).reshape(-1, 3) @ [(q + 1) ** 2, q + 1, 1]
    _, first, vertex = np.unique(place, return_index=True, return_inverse=True)
    if not np.array_equal(points[first[vertex]], points):
        raise MeshError(
            "damaged: the grids of its faces do not meet along the edges of a cube; write the file anew"
        )
    grid = vertex.reshape(6, q + 1, q + 1)
    a, b, c, d = (
        part.ravel()
        for part in (grid[:, :-1, :-1], grid[:, 1:, :-1], grid[:, 1:, 1:], grid[:, :-1, 1:])
    )
    triangles = np.concatenate([np.column_stack((a, b, c)), np.column_stack((a, c, d))])
    return RawMesh(points[first], of_triangles(triangles))


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write two numbered tables, each behind its count, with all digits; nothing else can be kept."""
    vertices, plates = (np.column_stack([np.arange(len(rows)) + 1, rows]) for rows in (v, f + 1))
    write_text(
        path,
        f"{len(v)}\n",
        {},
        ("%d %r %r %r\n", vertices),
        ("%d\n", np.array([[len(f)]])),
        ("%d %d %d %d\n", plates),
    )
