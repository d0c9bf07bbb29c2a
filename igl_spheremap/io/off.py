"""Object File Format, as text, with or without colours and normals (libigl's writer keeps 15 digits only)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import MeshError
from ..mesh.arrays import FloatArray, IntArray
from .reading import check_complete
from .records import Format, Metadata, RawMesh
from .text import counted_indices, numbers, read_rows, write_text

_NAMES = (b"OFF", b"COFF", b"NOFF", b"CNOFF", b"STOFF", b"STCOFF", b"STNOFF", b"STCNOFF")


def read(path: Path) -> RawMesh:
    """The positions and faces of an OFF file."""
    data = path.read_bytes()
    n, m, body = _header(data)
    rows = read_rows(data[body:])
    check_complete(len(rows) >= n + m, f"{len(rows)} lines", f"{n} vertices and {m} faces")
    return RawMesh(numbers(rows[:n], 3, "vertex"), counted_indices(rows[n : n + m]))


def _header(data: bytes) -> tuple[int, int, int]:
    """Numbers of vertices and faces, and where the lines begin that hold them."""
    words, at = list[bytes](), 0
    while len(words) < 2 and at < len(data):
        end = (data.find(b"\n", at) + 1) or len(data)
        words += data[at:end].partition(b"#")[0].split()
        at = end
        if words and words[0] in _NAMES:
            words = words[1:]
    if len(words) < 2 or not (words[0].isdigit() and words[1].isdigit()):
        raise MeshError(
            "damaged: no OFF header with the numbers of vertices and faces (binary and "
            "four-dimensional OFF are not read); check that the file is what its name says"
        )
    return int(words[0]), int(words[1]), at


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write all digits, and the mark as a comment."""
    counts = np.array([[len(v), len(f)]])
    write_text(path, "OFF\n", metadata, ("%r %r 0\n", counts), ("%r %r %r\n", v), ("3 %r %r %r\n", f))


FORMAT = Format("OFF", (".off",), read, write, magic=(b"OFF", b"COFF", b"NOFF", b"CNOFF"))
