"""PLY, text and binary of either byte order; written as binary doubles, which are exact.

libigl's reader aborts the process on polygons in a text file, returns memory that it never filled for a file
that is cut off, and hangs on a large vertex count: here sizes are checked against the file before it is read.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import MeshError
from .ply_header import Element, Header, parse_header
from .polygons import Polygons
from .records import FloatArray, Format, IntArray, Metadata, RawMesh
from .text import counted_indices, numbers, read_rows

_CORNERS = ("vertex_indices", "vertex_index")


def read(path: Path) -> RawMesh:
    """Read a PLY file.

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
        If the header makes no sense or the file ends early.
    """
    data = path.read_bytes()
    header = parse_header(data)
    vertex, face = _element(header, "vertex"), _element(header, "face")
    names = [p.name for p in vertex.properties]
    if not {"x", "y", "z"} <= set(names):
        raise MeshError("damaged: the PLY header announces no x, y, z; write the file anew")
    if not any(p.count is not None and p.name in _CORNERS for p in face.properties):
        raise MeshError(
            f"damaged: the PLY header announces no list {_CORNERS[0]} for faces; write the file anew"
        )
    return _read_ascii(data, header) if header.ascii else _read_binary(data, header)


def _element(header: Header, name: str) -> Element:
    for element in header.elements:
        if element.name == name:
            return element
    raise MeshError(
        f"no {name} element in the PLY header: a point cloud or another kind of data; give a closed "
        "triangle mesh"
    )


def _read_ascii(data: bytes, header: Header) -> RawMesh:
    rows = read_rows(data[header.end :])
    announced = sum(element.size for element in header.elements)
    if len(rows) < announced:
        raise _cut_off(f"{len(rows)} lines follow where {announced} are announced")
    v, faces, at = np.empty((0, 3)), Polygons(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)), 0
    for element in header.elements:
        own, at = rows[at : at + element.size], at + element.size
        names = [p.name for p in element.properties]
        if element.name == "vertex":
            v = np.ascontiguousarray(
                numbers(own, len(names), "vertex")[:, [names.index(axis) for axis in "xyz"]]
            )
        elif element.name == "face":
            lead = next(
                i for i, p in enumerate(element.properties) if p.count is not None and p.name in _CORNERS
            )
            if any(p.count is not None for p in element.properties[:lead]):
                raise MeshError(
                    f"the PLY file has lists before {_CORNERS[0]}, which are not read; write it anew"
                )
            faces = counted_indices(own, lead)
    return RawMesh(v, faces)


def _read_binary(data: bytes, header: Header) -> RawMesh:
    v, faces, at = (
        np.empty((0, 3)),
        Polygons(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)),
        header.end,
    )
    for element in header.elements:
        if element.name == "face":
            faces, at = _binary_faces(data, at, element)
            continue
        table, at = _records(data, at, element, {})
        if element.name == "vertex":
            v = np.column_stack([table[axis].astype(np.float64) for axis in "xyz"])
    return RawMesh(v, faces)


def _records(data: bytes, at: int, element: Element, lengths: dict[str, int]) -> tuple[NDArray[Any], int]:
    """The rows of an element whose lists have these lengths, and where they end."""
    fields: list[Any] = []
    for p in element.properties:
        if p.count is None:
            fields.append((p.name, p.type))
        elif p.name in lengths:
            fields += [(f"{p.name} length", p.count), (p.name, p.type, (lengths[p.name],))]
        else:
            raise MeshError(
                f"the PLY file has lists for element {element.name}, which are not read; write it anew"
            )
    dtype = np.dtype(fields)
    end = at + element.size * dtype.itemsize
    if end > len(data):
        raise _cut_off(
            f"{len(data) - at} bytes are left where {element.size} rows of {element.name} are announced"
        )
    return np.frombuffer(data, dtype, element.size, at), end


def _binary_faces(data: bytes, at: int, element: Element) -> tuple[Polygons, int]:
    """Faces at once where all rows have the lengths of the first one, else row by row."""
    name = next(p.name for p in element.properties if p.count is not None and p.name in _CORNERS)
    if element.size == 0:
        return Polygons(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)), at
    _, lengths, _ = _row(data, at, element)
    try:
        table, end = _records(data, at, element, lengths)
    except MeshError:
        table = None  # later rows may be shorter
    if table is not None and all((table[f"{key} length"] == k).all() for key, k in lengths.items()):
        corners = np.asarray(table[name], dtype=np.int64)
        return Polygons(corners.ravel(), np.full(len(corners), lengths[name])), end
    faces = []
    for _ in range(element.size):
        lists, _, at = _row(data, at, element)
        faces.append(lists[name])
    return Polygons(np.concatenate(faces), np.array([len(face) for face in faces])), at


def _row(data: bytes, at: int, element: Element) -> tuple[dict[str, IntArray], dict[str, int], int]:
    """The lists of the row at a place in the file, their lengths, and where the row ends."""
    lists, lengths = dict[str, IntArray](), dict[str, int]()
    try:
        for p in element.properties:
            if p.count is None:
                at += p.type.itemsize
                continue
            lengths[p.name] = int(np.frombuffer(data, p.count, 1, at)[0])
            at += p.count.itemsize
            lists[p.name] = np.frombuffer(data, p.type, lengths[p.name], at).astype(np.int64)
            at += p.type.itemsize * lengths[p.name]
    except ValueError:
        raise _cut_off(f"the file ends within the {element.size} rows of {element.name}") from None
    return lists, lengths, at


def _cut_off(what: str) -> MeshError:
    return MeshError(f"damaged: {what}; the file seems cut off, write it anew")


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write a binary PLY file in double precision.

    Parameters
    ----------
    path : Path
        The file.
    v : (n, 3) float64 array
        Positions.
    f : (m, 3) int64 array
        Faces.
    metadata : dict
        ``vertex_properties``: further columns by name, (n,) arrays of uint8, float32 or float64, such as
        ``red``, ``green``, ``blue`` and ``quality``.

    Returns
    -------
    None
    """
    columns = {"x": v[:, 0], "y": v[:, 1], "z": v[:, 2]} | dict(metadata.get("vertex_properties", {}))
    kinds = {key: column.dtype.newbyteorder("<") for key, column in columns.items()}
    vertices = np.empty(len(v), dtype=list(kinds.items()))
    for key, column in columns.items():
        vertices[key] = column
    faces = np.empty(len(f), dtype=[("size", "u1"), ("corners", "<i4", (3,))])
    faces["size"], faces["corners"] = 3, f
    words = {"u1": "uchar", "f4": "float", "f8": "double"}
    with path.open("wb") as file:
        file.write(
            "\n".join(
                [
                    "ply",
                    "format binary_little_endian 1.0",
                    f"element vertex {len(v)}",
                    *(f"property {words[kind.str[1:]]} {key}" for key, kind in kinds.items()),
                    f"element face {len(f)}",
                    "property list uchar int vertex_indices",
                    "end_header\n",
                ]
            ).encode()
        )
        file.write(vertices.tobytes())
        file.write(faces.tobytes())


FORMAT = Format("PLY", (".ply",), read, write, magic=(b"ply\n", b"ply\r\n"))
