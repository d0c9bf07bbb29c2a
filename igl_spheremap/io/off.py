"""OFF files: positions and faces. libigl's writer keeps 15 digits of them."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ..errors import MeshError
from ..mesh.arrays import FloatArray, IntArray
from .reading import check_complete
from .records import Metadata, RawMesh
from .text import counted_indices, numbers, read_rows, write_text

_GAP = rb"(?:\s|#.*\n)"
#: Beginning of OFF files: name, which may be missing, numbers of vertices and faces, and the rest of the line.
_HEADER = re.compile(
    rb"GAP*(?:(?:ST)?C?N?OFFGAP+)?(\d+)GAP+(\d+)(?=[\s#]|\Z).*\n?".replace(b"GAP", _GAP)
)


def read(path: Path) -> RawMesh:
    """The positions and faces of an OFF file."""
    data = path.read_bytes()
    header = _HEADER.match(data)
    if header is None:
        raise MeshError(
            "damaged: no OFF header with the numbers of vertices and faces (binary and "
            "four-dimensional OFF are not read); check that the file is what its name says"
        )
    n, m = int(header[1]), int(header[2])
    rows = read_rows(data[header.end() :])
    check_complete(len(rows) >= n + m, f"{len(rows)} lines", f"{n} vertices and {m} faces")
    return RawMesh(numbers(rows[:n], 3, "vertex"), counted_indices(rows[n : n + m]))


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write all digits, and the mark as a comment."""
    counts = np.array([[len(v), len(f)]])
    write_text(
        path, "OFF\n", metadata, ("%r %r 0\n", counts), ("%r %r %r\n", v), ("3 %r %r %r\n", f)
    )
