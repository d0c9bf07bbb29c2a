"""STL, text and binary: triangles without shared vertices, welded where corners have equal coordinates."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import numpy as np

from ..errors import MeshError
from ..mesh.arrays import FloatArray, IntArray, weld
from .records import Metadata, RawMesh, of_triangles
from .text import numbers, read_rows

_TRIANGLE = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEADER = 84  # bytes: a text of 80, and the number of triangles


def read(path: Path) -> RawMesh:
    """Read triangles, and weld corners at the same place; vertices have the order in which they first appear."""
    data = path.read_bytes()
    count = struct.unpack_from("<I", data, _HEADER - 4)[0] if len(data) >= _HEADER else None
    # binary ones may say "solid" too
    if count is not None and len(data) == _HEADER + count * _TRIANGLE.itemsize:
        soup = (
            np.frombuffer(data, _TRIANGLE, count, _HEADER)["corners"]
            .reshape(-1, 3)
            .astype(np.float64)
        )
    elif re.match(rb"\s*solid\b", text := data.lower()):  # some programs write capitals
        rows = read_rows(text).starting_with(b"vertex")
        if len(rows) % 3 or not re.search(rb"\bendsolid\b", text):
            raise MeshError(
                f"damaged: text STL with {len(rows)} corners and no proper end; the file seems cut off, "
                "write it anew"
            )
        soup = numbers(rows, 3, "corner")
    else:
        raise MeshError(
            f"damaged: neither text STL nor binary STL, whose size would be {_HEADER} bytes and "
            f"{_TRIANGLE.itemsize} for each triangle; the file seems cut off, write it anew"
        )
    v, index = weld(soup)
    return RawMesh(v, of_triangles(index.reshape(-1, 3)))


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write binary STL: float32, with the mark as its header; the order of the vertices is lost."""
    triangles = np.zeros(len(f), dtype=_TRIANGLE)
    triangles["corners"] = v[f]
    a, b, c = (v[f[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    triangles["normal"] = np.divide(normal, size, out=np.zeros_like(normal), where=size > 0)
    header = metadata.get("mark", "binary STL").encode()
    with path.open("wb") as file:
        file.write(header.ljust(_HEADER - 4)[: _HEADER - 4] + struct.pack("<I", len(f)))
        file.write(triangles.tobytes())
