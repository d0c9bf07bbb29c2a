"""PLY, text and binary of either byte order; written as binary doubles, which are exact.

A surface with its map has six coordinates a vertex: ``x y z``, and ``px py pz`` on the sphere, as Moebius registration
(Baden, Crane and Kazhdan 2018) reads and writes them.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FileError, MeshError
from ..mesh.arrays import FloatArray, IntArray
from .reading import check_complete
from .records import Metadata, Polygons, RawMesh
from .text import TextRows, counted_indices, numbers, read_rows

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


@dataclass
class PlyElement:
    """A table of the file: its name, the number of its rows, and its columns."""

    name: str
    size: int
    properties: list[PlyProperty] = field(default_factory=list)

    def index(self, name: str) -> int:
        """The place of a column, -1 if there is none of that name."""
        return next((k for k, each in enumerate(self.properties) if each.name == name), -1)


def read(path: Path) -> RawMesh:
    """Positions, faces, and the sphere, of a PLY file, whatever else it holds."""
    names, x, faces = _read(path, (*POSITIONS, *SPHERE))
    if names[3:] != SPHERE:
        return RawMesh(x[:, :3], faces)
    return RawMesh(x[:, :3], faces, sphere=x[:, 3:])


def read_scalars(path: Path) -> dict[str, NDArray[Any]]:
    """The properties of vertices that are numbers, but their positions."""
    names, x, _ = _read(path)
    return {name: column for name, column in zip(names, x.T, strict=True) if name not in POSITIONS}


def _read(
    path: Path, wanted: tuple[str, ...] | None = None
) -> tuple[tuple[str, ...], FloatArray, Polygons]:
    """Names and columns of the wanted properties of vertices, by default of all that are numbers, and faces."""
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
    numbers, corners = _mesh_columns(layout)
    names = tuple(numbers)
    if wanted is not None:
        names = tuple(name for name in wanted if name in numbers)
    read_rows_of = _read_text
    if order:
        read_rows_of = _read_binary
    return names, *read_rows_of(body, layout, [numbers[name] for name in names], corners)


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


def _place(layout: list[PlyElement], name: str) -> int:
    """The place of the last element of that name; a MeshError if there is none."""
    places = [k for k, element in enumerate(layout) if element.name == name]
    if not places:
        raise MeshError(
            f"no {name} element in the PLY header: a point cloud or another kind of data; give a closed "
            "triangle mesh"
        )
    return places[-1]


def _mesh_columns(layout: list[PlyElement]) -> tuple[dict[str, int], int]:
    """The columns of a vertex's numbers by name, and that of the corners of faces; files without these are refused."""
    vertex, face = (layout[_place(layout, name)] for name in ("vertex", "face"))
    numbers = {each.name: k for k, each in enumerate(vertex.properties) if each.count is None}
    if not set(POSITIONS) <= set(numbers):
        raise MeshError("damaged: the PLY header announces no x, y, z; write the file anew")
    corners = max(map(face.index, _CORNERS))
    if corners < 0 or (found := face.properties[corners]).count is None or found.type.kind == "f":
        raise MeshError(
            f"damaged: the PLY header announces no list {_CORNERS[0]} of whole numbers; write the file "
            "anew"
        )
    return numbers, corners


def _read_text(
    body: bytes, layout: list[PlyElement], columns: list[int], corners: int
) -> tuple[FloatArray, Polygons]:
    rows, end = read_rows(body), np.cumsum([element.size for element in layout])
    check_complete(len(rows) >= end[-1], f"{len(rows)} lines", f"{end[-1]}")

    def own(name: str, wanted: int | None = None) -> TextRows:
        k = _place(layout, name)
        if any(each.count is not None for each in layout[k].properties[:wanted]):
            raise MeshError(
                f"lists before {_CORNERS[0]} or among the numbers of a vertex are not read from text; "
                "write it anew in binary"
            )
        return rows[end[k] - layout[k].size : end[k]]

    width = len(layout[_place(layout, "vertex")].properties)
    return numbers(own("vertex"), width, "vertex")[:, columns], counted_indices(
        own("face", corners), corners
    )


def _read_binary(
    body: bytes, layout: list[PlyElement], columns: list[int], corners: int
) -> tuple[FloatArray, Polygons]:
    at, wanted = 0, {_place(layout, "vertex"): columns, _place(layout, "face"): [corners]}
    found = {}
    for k, element in enumerate(layout):
        found[k], at = _rows(body, at, element, wanted.get(k, []))
    vertices, [(faces, sizes)] = (found[k] for k in wanted)
    x = np.column_stack([values.astype(np.float64) for values, _ in vertices])
    return x, Polygons(faces.astype(np.int64), sizes)


def _rows(
    body: bytes, at: int, element: PlyElement, wanted: list[int]
) -> tuple[list[tuple[NDArray[Any], IntArray]], int]:
    """The wanted columns of the rows that begin at a byte, each with the lengths of its lists, and the rows' end.

    All rows at once where lists are as long as in the first row, else row by row.
    """
    first, _ = _walk(body, at, element, min(1, element.size))
    fields: list[Any] = []
    lengths: dict[int, int] = {}
    for k, (part, column) in enumerate(zip(first, element.properties, strict=True)):
        lengths[k] = len(b"".join(part)) // column.type.itemsize
        if column.count is not None:
            fields.append((f"count{k}", column.count))
        fields.append((str(k), column.type, (lengths[k],)))
    row = np.dtype(fields)
    lists = [k for k, column in enumerate(element.properties) if column.count is not None]
    end = at + element.size * row.itemsize
    if end <= len(body):
        table = np.frombuffer(body, row, element.size, at)
        if all((table[f"count{k}"] == lengths[k]).all() for k in lists):
            return [(table[str(k)].ravel(), np.full(element.size, lengths[k])) for k in wanted], end
    check_complete(bool(lists), f"{len(body) - at} bytes", f"{element.size} rows of {element.name}")
    parts, end = _walk(body, at, element, element.size)
    found = []
    for k in wanted:
        kind = element.properties[k].type
        sizes = np.array([len(part) for part in parts[k]]) // kind.itemsize
        found.append((np.frombuffer(b"".join(parts[k]), kind), sizes))
    return found, end


def _walk(body: bytes, at: int, element: PlyElement, rows: int) -> tuple[list[list[bytes]], int]:
    """The bytes of each column's value or list in each row, and the end of the rows that begin at a byte."""
    parts: list[list[bytes]] = [[] for _ in element.properties]
    for _ in range(rows):
        for part, column in zip(parts, element.properties, strict=True):
            size = column.type.itemsize
            if column.count is not None:
                number = body[at : at + column.count.itemsize].ljust(column.count.itemsize, b"\0")
                size *= int(np.frombuffer(number, column.count)[0])
                at += len(number)
            if size < 0 or at + size > len(body):
                raise MeshError(
                    f"damaged: {size} bytes of {column.name} in a row of {element.name}, where the file "
                    "holds fewer; it seems cut off, write it anew"
                )
            part.append(body[at : at + size])
            at += size
    return parts, at


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
