"""Object File Format, as text, with or without colours and normals (libigl's writer keeps 15 digits only)."""

from __future__ import annotations

from pathlib import Path

from ..errors import MeshError
from ..mesh.arrays import FloatArray, IntArray
from .records import Format, Metadata, RawMesh
from .text import counted_indices, numbers, read_rows, write_rows

_NAMES = (b"OFF", b"COFF", b"NOFF", b"CNOFF", b"STOFF", b"STCOFF", b"STNOFF", b"STCNOFF")


def read(path: Path) -> RawMesh:
    """The positions and faces of an OFF file."""
    data = path.read_bytes()
    n, m, body = _header(data)
    rows = read_rows(data[body:])
    if len(rows) < n + m:
        raise MeshError(
            f"damaged: {len(rows)} lines follow where {n} vertices and {m} faces are announced; "
            "the file seems cut off, write it anew"
        )
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
    with path.open("wb") as file:
        file.write(b"OFF\n")
        if "mark" in metadata:
            file.write(f"# {metadata['mark']}\n".encode())
        file.write(f"{len(v)} {len(f)} 0\n".encode())
        write_rows(file, "%r %r %r\n", v)
        write_rows(file, "3 %r %r %r\n", f)


FORMAT = Format("OFF", (".off",), read, write, magic=(b"OFF", b"COFF", b"NOFF", b"CNOFF"))
