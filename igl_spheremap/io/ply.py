"""PLY, text and binary of either byte order; written as binary doubles, which are exact.

A surface with its map has six coordinates a vertex: ``x y z``, and ``px py pz`` on the sphere, as Moebius registration
(Baden, Crane and Kazhdan 2018) reads and writes them.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FileError, MeshError, within
from ..mesh.arrays import AnyArray, FloatArray, IntArray
from .reading import Bytes, check_complete
from .records import Metadata, NamedArrays, Polygons, RawMesh, ScalarMaps
from .text import counted_indices, numbers, read_rows

#: Programs write its last line in binary, its others as text, whose ends are the system's.
_HEADER = re.compile(
    rb"ply[ \t]*(\r\n|\n|\r)(?:.*?[\r\n])??end_header[ \t]*(?:\1|\r?\n)", re.DOTALL
)
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip
_NAMES = {kind: name for name, kind in _TYPES.items() if not name[-1].isdigit()}
_CORNERS = ("vertex_indices", "vertex_index")
#: Names of the properties that hold positions.
POSITIONS, SPHERE = ("x", "y", "z"), ("px", "py", "pz")


@dataclass(frozen=True)
class PlyProperty:
    """A column of an element: a number in each row or, if `count` is a type, a list with its length before it."""

    name: str
    type: np.dtype[Any]
    count: np.dtype[Any] | None = None

    @property
    def least(self) -> int:
        """Bytes that a row of it takes at least, in binary."""
        if self.count is None:
            return self.type.itemsize
        return self.count.itemsize

    @property
    def holds_corners(self) -> bool:
        """Whether it is the list of the corners of faces."""
        return self.name in _CORNERS and self.count is not None and self.type.kind != "f"


@dataclass
class PlyElement:
    """A table of the file: its name, the number of its rows, and its columns."""

    name: str
    size: int
    properties: list[PlyProperty] = field(default_factory=list)


def read(path: Path) -> RawMesh:
    """Positions, faces, and the sphere, of a PLY file, whatever else it holds."""
    columns, faces = _read(path)
    v = np.column_stack([columns[name] for name in POSITIONS])
    if not set(SPHERE) <= columns.keys():
        return RawMesh(v, faces)
    return RawMesh(v, faces, sphere=np.column_stack([columns[name] for name in SPHERE]))


def read_scalars(path: Path) -> NamedArrays:
    """The properties of vertices that are numbers, but their positions."""
    columns, _ = _read(path)
    return {name: column for name, column in columns.items() if name not in POSITIONS}


def _read(path: Path) -> tuple[ScalarMaps, Polygons]:
    """The properties of vertices that are numbers, by name, and the faces."""
    data = path.read_bytes()
    found = _HEADER.match(data, 0, 1 << 16)
    if found is None:
        raise MeshError("damaged: no PLY header; check that the file is what its name says")
    order, layout = _layout(re.split("[\r\n]+", found[0].decode("ascii", "replace")))
    body = data[found.end() :]
    for element in layout:
        least = len(element.properties)
        if order:
            least = sum(each.least for each in element.properties)
        fit = 0 <= element.size * max(1, least) <= len(body)
        check_complete(fit, f"{len(body)} bytes", f"{element.size} rows of {element.name}")
    known = {element.name: element for element in layout}
    for name in ("vertex", "face"):
        if name not in known:
            raise MeshError(
                f"no {name} element in the PLY header: a point cloud or another kind of data; give a closed "
                "triangle mesh"
            )
    names = [each.name for each in known["vertex"].properties if each.count is None]
    if not {*POSITIONS} <= {*names}:
        raise MeshError("damaged: the PLY header announces no x, y, z; write the file anew")
    corners = [each for each in known["face"].properties if each.holds_corners]
    if not corners:
        raise MeshError(
            f"damaged: the PLY header announces no list {_CORNERS[0]} of whole numbers; write the file "
            "anew"
        )
    read_body = _read_text
    if order:
        read_body = _read_binary
    columns, faces = read_body(body, layout, corners[0])
    return {name: columns[name].astype(np.float64) for name in names}, faces


def _layout(lines: list[str]) -> tuple[str, list[PlyElement]]:
    """The byte order, empty for text, and the elements that a header announces."""
    order, announced = "<", False
    layout: list[PlyElement] = []
    for line in lines[1:]:
        try:
            match line.split():
                case ["format", kind, _]:
                    order, announced = _ORDERS[kind], True
                case ["element", name, size]:
                    layout.append(PlyElement(name, int(size)))
                case ["property", "list", count, kind, name]:
                    counted = np.dtype(order + _TYPES[count])
                    if counted.kind == "f":
                        raise ValueError
                    column = PlyProperty(name, np.dtype(order + _TYPES[kind]), counted)
                    layout[-1].properties.append(column)
                case ["property", kind, name]:
                    layout[-1].properties.append(PlyProperty(name, np.dtype(order + _TYPES[kind])))
                case [] | ["comment" | "obj_info" | "end_header", *_]:
                    continue
                case _:
                    raise ValueError
        except (IndexError, KeyError, ValueError):
            raise MeshError(
                f"damaged: the PLY header reads {line.strip()[:60]!a}; write the file anew"
            ) from None
    if not announced:
        raise MeshError("damaged: the PLY header announces no format; write the file anew")
    return order, layout


def _read_text(
    body: bytes, layout: list[PlyElement], corners: PlyProperty
) -> tuple[NamedArrays, Polygons]:
    """The columns of vertices by name, and the faces, of a line each."""
    rows, at, own = read_rows(body), 0, {}
    for element in layout:
        own[element.name] = rows[at : at + element.size], element.properties
        at += element.size
    check_complete(len(rows) >= at, f"{len(rows)} lines", f"{at}")
    (vertices, columns), (faces, of_faces) = own["vertex"], own["face"]
    lead = of_faces.index(corners)
    if any(each.count is not None for each in (*columns, *of_faces[:lead])):
        raise MeshError(
            f"lists before {_CORNERS[0]} or among the numbers of a vertex are not read from text; "
            "write it anew in binary"
        )
    x = numbers(vertices, len(columns), "vertex").T
    named = {column.name: each for column, each in zip(columns, x, strict=True)}
    return named, counted_indices(faces, lead)


def _read_binary(
    body: bytes, layout: list[PlyElement], corners: PlyProperty
) -> tuple[NamedArrays, Polygons]:
    """The columns of vertices by name, and the faces, of rows of bytes."""
    file, own = Bytes(body), {}
    for element in layout:
        try:
            columns = zip(element.properties, _columns(file, element), strict=True)
        except MeshError as error:
            raise within(error, f"rows of {element.name}: ") from None
        own[element.name] = element.size, {each.name: values for each, values in columns}
    m, of_faces = own["face"]
    faces, sizes = of_faces[corners.name]
    named = {name: values for name, (values, _) in own["vertex"][1].items()}
    return named, Polygons(faces.astype(np.int64), np.full(m, sizes))


def _columns(file: Bytes, element: PlyElement) -> Sequence[tuple[AnyArray, IntArray | int]]:
    """The values of each column, those of all rows in one array, and how many of them a row has.

    If lists are as long as in the first row, all rows are taken at once, else one by one.
    """
    begin, fields = file.at, list[Any]()
    first = _by_row(file, element, min(1, element.size))
    if not element.size:
        return first
    for k, (values, _) in enumerate(first):
        column = element.properties[k]
        if column.count is not None:
            fields.append((f"count{k}", column.count))
        fields.append((str(k), column.type, (len(values),)))
    row = np.dtype(fields)
    lengths = {k: row[str(k)].shape[0] for k in range(len(element.properties))}
    lists = [k for k, each in enumerate(element.properties) if each.count is not None]
    file.at = begin
    if not lists or element.size * row.itemsize <= len(file.data) - begin:
        table = file.array(row, element.size)
        if all((table[f"count{k}"] == lengths[k]).all() for k in lists):
            return [(table[str(k)].ravel(), length) for k, length in lengths.items()]
        file.at = begin
    return _by_row(file, element, element.size)


def _by_row(
    file: Bytes, element: PlyElement, rows: int
) -> Sequence[tuple[AnyArray, IntArray | int]]:
    """The same of the next rows, whatever the lengths of their lists."""
    parts: list[list[bytes]] = [[] for _ in element.properties]
    for _ in range(rows):
        for part, column in zip(parts, element.properties, strict=True):
            size = column.type.itemsize
            if column.count is not None:
                size *= file.number(column.count)
            part.append(file.take(size))
    found = []
    for part, column in zip(parts, element.properties, strict=True):
        sizes = np.array([len(each) for each in part], dtype=np.int64) // column.type.itemsize
        found.append((np.frombuffer(b"".join(part), column.type), sizes))
    return found


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write binary doubles, and the mark as a comment.

    The (n, 3) array ``sphere`` of the metadata goes beside the positions, and the (n,) arrays of ``vertex_properties``
    behind them by name, as ``red``.
    """
    columns = dict(zip(POSITIONS, v.T, strict=True))
    if "sphere" in metadata:
        columns |= dict(zip(SPHERE, metadata["sphere"].T, strict=True))
    for name, values in metadata.get("vertex_properties", {}).items():
        word = re.sub("^$|[^!-~]+", "_", name)
        if word in (*columns, *SPHERE):
            raise FileError(
                f"a .ply file can't hold data called {word}, a name that is taken; write .vtk"
            )
        columns[word] = values
    kinds = [(name, column.dtype.newbyteorder("<")) for name, column in columns.items()]
    vertices = np.empty(len(v), kinds)
    for name, column in columns.items():
        vertices[name] = column
    faces = np.empty(len(f), dtype=[("size", "u1"), ("corners", "<i4", (3,))])
    faces["size"], faces["corners"] = 3, f
    head = ["ply", "format binary_little_endian 1.0"]
    if "mark" in metadata:
        head.append(f"comment {metadata['mark']}")
    head += [
        f"element vertex {len(v)}",
        *(f"property {_NAMES[kind.str[1:]]} {name}" for name, kind in kinds),
        f"element face {len(f)}",
        f"property list uchar int {_CORNERS[0]}",
        "end_header",
    ]
    with path.open("wb") as file:
        file.write("".join(f"{line}\n" for line in head).encode("ascii"))
        file.write(vertices.tobytes())
        file.write(faces.tobytes())
