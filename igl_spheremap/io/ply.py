"""PLY, text and binary of either byte order, by plyfile; written as binary doubles, which are exact.

plyfile handles one row at a time, in Python: 20 us for a face in text, 4 us for one that it reads or writes in binary.
So text is read as that of OFF files, binary triangles and quads are read at once, and plyfile writes the header only.
"""

from __future__ import annotations

import re
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import MeshError, import_optional
from ..mesh.arrays import FloatArray, IntArray
from .reading import check_complete
from .records import Format, Metadata, Polygons, RawMesh
from .text import counted_indices, numbers, read_rows

_HEADER = re.compile(rb"ply(\r\n|\n|\r)(?:.*?\1)??end_header[ \t]*\1", re.DOTALL)
_COUNT = re.compile(rb"^(element[ \t]+\S+)[ \t]+(-?\d+)$", re.MULTILINE)
_LONGEST = 1 << 16  # bytes of a header, which plyfile reads one by one
_CORNERS = ("vertex_indices", "vertex_index")


def read(path: Path) -> RawMesh:
    """The positions and faces of a PLY file, whatever else it holds."""
    plyfile = import_optional("plyfile", "PLY")
    data = path.read_bytes()
    found = _HEADER.match(data[:_LONGEST])
    if found is None:
        raise MeshError("damaged: no PLY header; check that the file is what its name says")
    text = b"\n".join(line.strip() for line in found[0].split(found[1]))
    header = text.decode("ascii", "replace").encode("ascii", "replace")  # comments may hold any bytes
    layout = plyfile.PlyData.read(BytesIO(_COUNT.sub(rb"\1 0", header)))  # elements without rows
    sizes = [int(size) for _, size in _COUNT.findall(header)]
    for element, size in zip(layout, sizes, strict=True):
        least = len(element.properties) + (3 if element.name == "face" else 0)  # bytes of a row
        fit = 0 <= size * max(1, least) <= len(data) - found.end()
        check_complete(fit, f"{len(data) - found.end()} bytes", f"{size} rows of {element.name}")
    corners = _corners(layout)
    if layout.text:
        return _read_text(data[found.end() :], layout, sizes, corners)
    intact = header == found[0].replace(found[1], b"\n")  # else plyfile refuses the header
    body = _read_binary(plyfile, str(path) if intact else BytesIO(header + data[found.end() :]), corners)
    v, faces = np.column_stack([body["vertex"][axis] for axis in "xyz"]), body["face"][corners]
    if faces.dtype != object:
        return RawMesh(v, Polygons(faces.astype(np.int64).ravel(), np.full(len(faces), faces.shape[1])))
    every = np.concatenate([np.empty(0, dtype=np.int64), *faces]).astype(np.int64)
    return RawMesh(v, Polygons(every, np.array([len(face) for face in faces], dtype=np.int64)))


def _read_binary(plyfile: Any, source: str | BytesIO, corners: str) -> Any:
    """The file as plyfile reads it: at once where all faces have three corners or four, else face by face."""
    for size in (3, 4):
        try:
            return plyfile.PlyData.read(source, known_list_len={"face": {corners: size}})
        except plyfile.PlyElementParseError:  # other polygons, or damage
            if isinstance(source, BytesIO):
                source.seek(0)
    return plyfile.PlyData.read(source)


def _corners(layout: Any) -> str:
    """The name of the list that holds the corners of faces; files without one, or without positions, are refused."""
    for name in ("vertex", "face"):
        if name not in layout:
            raise MeshError(f"no {name} element in the PLY header: a point cloud or another kind of data; give a "
                            "closed triangle mesh")
    if not all(axis in layout["vertex"] for axis in "xyz"):
        raise MeshError("damaged: the PLY header announces no x, y, z; write the file anew")
    for name in _CORNERS:
        if name in layout["face"]:
            corners = layout["face"].ply_property(name)
            if hasattr(corners, "list_dtype") and "f" not in corners.val_dtype:
                return name
    raise MeshError(f"damaged: the PLY header announces no list {_CORNERS[0]} of whole numbers; write the file anew")


def _read_text(text: bytes, layout: Any, sizes: list[int], corners: str) -> RawMesh:
    rows, end = read_rows(text), np.cumsum(sizes)
    check_complete(len(rows) >= end[-1], f"{len(rows)} lines", f"{end[-1]}")
    own = {element.name: rows[stop - size : stop] for element, size, stop in zip(layout, sizes, end, strict=True)}
    columns = {name: [p.name for p in layout[name].properties] for name in ("vertex", "face")}
    before = columns["face"][: columns["face"].index(corners)]
    for name, scalars in (("vertex", columns["vertex"]), ("face", before)):
        if any(hasattr(layout[name].ply_property(scalar), "list_dtype") for scalar in scalars):
            raise MeshError(f"lists before {corners} or among the numbers of a vertex are not read from text; write it "
                            "anew in binary")
    v = numbers(own["vertex"], len(columns["vertex"]), "vertex")[:, [columns["vertex"].index(axis) for axis in "xyz"]]
    return RawMesh(v, counted_indices(own["face"], len(before)))


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write binary doubles, the mark as a comment, and the (n,) arrays of ``vertex_properties`` by name, as ``red``."""
    plyfile = import_optional("plyfile", "PLY")
    columns = {"x": v[:, 0], "y": v[:, 1], "z": v[:, 2]} | dict(metadata.get("vertex_properties", {}))
    vertices = np.empty(len(v), dtype=[(name, column.dtype.newbyteorder("<")) for name, column in columns.items()])
    for name, column in columns.items():
        vertices[name] = column
    corners = ("vertex_indices", "<i4", (3,))
    faces = np.empty(len(f), dtype=[("size", "u1"), corners])
    faces["size"], faces["vertex_indices"] = 3, f
    elements = [plyfile.PlyElement.describe(vertices, "vertex"),
                plyfile.PlyElement.describe(np.empty(len(f), dtype=[corners]), "face")]
    comments = [metadata["mark"]] if "mark" in metadata else []
    with path.open("wb") as file:
        file.write(f"{plyfile.PlyData(elements, byte_order='<', comments=comments).header}\n".encode())
        file.write(vertices.tobytes())
        file.write(faces.tobytes())


FORMAT = Format("PLY", (".ply",), read, write, magic=(b"ply\n", b"ply\r"))
