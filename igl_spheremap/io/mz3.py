"""MZ3, the surfaces of Surf Ice and NiiVue, packed or not; float32. They are read only."""

from __future__ import annotations

import gzip
import struct
from io import BytesIO
from pathlib import Path

import numpy as np

from ..errors import MeshError
from .formats import GZIP
from .reading import check_complete, check_expansion, expansion_limit
from .records import RawMesh, of_triangles

_HEADER = struct.Struct("<2sHIII")
_FACES, _POSITIONS = 1, 2  # bits that say what the file holds


def read(path: Path) -> RawMesh:
    """Triangles and positions, behind a header and what it says is to be skipped; colours and data are left out."""
    data = unpacked(path)
    _, holds, m, n, skipped = _HEADER.unpack_from(data)
    if not holds & _FACES or not holds & _POSITIONS:
        raise MeshError(
            "it holds colours or data without their surface; give the file of the surface"
        )
    begin = _HEADER.size + skipped
    size = begin + 12 * (m + n)
    check_complete(size <= len(data), f"{len(data)} bytes", str(size))
    faces = np.frombuffer(data, "<i4", 3 * m, begin).reshape(-1, 3)
    return RawMesh(
        np.frombuffer(data, "<f4", 3 * n, begin + 12 * m).reshape(-1, 3), of_triangles(faces)
    )


def unpacked(path: Path) -> bytes:
    """The bytes of a file, or those that it packs by gzip."""
    stored = path.read_bytes()
    if not stored.startswith(GZIP):
        return stored
    with gzip.open(BytesIO(stored)) as file:
        content = file.read(expansion_limit(len(stored)) + 1)
    check_expansion(len(content), len(stored))
    return content
