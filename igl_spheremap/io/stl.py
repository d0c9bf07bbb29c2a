"""STL, text and binary: triangles without shared vertices; corners with equal coordinates are welded."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ..errors import MeshError
from ..mesh.arrays import FloatArray, IntArray, weld
from .records import Metadata, RawMesh, of_triangles
from .text import numbers, read_rows

_TRIANGLE = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read(path: Path) -> RawMesh:
    """Read triangles, and weld corners at the same place; vertices have the order in which they first appear."""
    data = path.read_bytes()
    count = np.frombuffer(data[80:84].ljust(4, b"\0"), "<u4")[0]  # behind a text
    # binary ones may say "solid" too
    if len(data) == 84 + int(count) * _TRIANGLE.itemsize:
        corners = np.frombuffer(data, _TRIANGLE, offset=84)["corners"]
        soup = corners.reshape(-1, 3).astype(np.float64)
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
            "damaged: neither text STL nor binary STL, whose size would be 84 bytes and "
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
        file.write(header.ljust(80)[:80] + np.uint32(len(f)).astype("<u4").tobytes())
        file.write(triangles.tobytes())
