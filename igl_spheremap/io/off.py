"""Object File Format, as text, with or without colours and normals (libigl's writer keeps 15 digits only)."""

from __future__ import annotations

import re
from pathlib import Path

from ..errors import MeshError
from .records import FloatArray, Format, IntArray, Metadata, RawMesh
from .text import counted_indices, numbers, read_text, write_rows


def read(path: Path) -> RawMesh:
    """Read an OFF file.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    RawMesh
        Positions and faces.

    Raises
    ------
    MeshError
        If it is no OFF file, or ends early, or a row can't be made sense of.
    """
    data = read_text(path)
    if b"#" in data:
        data = re.sub(rb"#[^\r\n]*", b"", data)
    head = re.match(rb"\s*(?:(?:ST)?C?N?OFF\b)?\s*(\d+)[ \t]+(\d+)(?:[ \t]+\d+)?[ \t]*(?:\r?\n|$)", data)
    if head is None:
        raise MeshError(
            "damaged: no OFF header with the numbers of vertices and faces (binary and "
            "four-dimensional OFF are not read); check that the file is what its name says"
        )
    n, m = int(head[1]), int(head[2])
    rows = [row for line in data[head.end() :].splitlines() if (row := line.split())]
    if len(rows) < n + m:
        raise MeshError(
            f"damaged: {len(rows)} lines follow where {n} vertices and {m} faces are announced; "
            "the file seems cut off, write it anew"
        )
    return RawMesh(numbers(rows[:n], 3, "vertex"), counted_indices(rows[n : n + m]))


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write an OFF file with all digits.

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
        file.write(f"OFF\n{len(v)} {len(f)} 0\n".encode())
        write_rows(file, "%r %r %r\n", v)
        write_rows(file, "3 %r %r %r\n", f)


FORMAT = Format("OFF", (".off",), read, write, magic=(b"OFF", b"COFF", b"NOFF", b"CNOFF"))
