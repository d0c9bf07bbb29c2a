"""VTK's legacy files (.vtk), versions 3.0 to 5.1, as text and in binary; written in binary doubles, which are exact.

Triangles and point data are kept; points without faces, lines, cell data and field data are passed over.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

import numpy as np
from numpy.typing import NDArray

from ..errors import MeshError
from ..mesh.arrays import FloatArray, IntArray
from .reading import check_complete
from .records import Metadata, Polygons, RawMesh

_HEADER = re.compile(rb"# vtk DataFile Version (\d+)\.\d+[^\n]*\n[^\n]*\n\s*(ASCII|BINARY)\s*?\n", re.IGNORECASE)
_LINE = re.compile(rb"\s*([^\r\n]*)(?:\r?\n|\r|\Z)")
_TYPES = {
    "unsigned_char": "u1", "char": "i1", "signed_char": "i1", "unsigned_short": "u2", "short": "i2",
    "unsigned_int": "u4", "int": "i4", "unsigned_long": "u8", "long": "i8", "vtktypeuint64": "u8",
    "vtktypeint64": "i8", "vtkidtype": "i4", "float": "f4", "double": "f8", "bit": "bit",
}  # fmt: skip
_NAMES = {"u1": "unsigned_char", "i1": "signed_char", "u2": "unsigned_short", "i2": "short", "u4": "unsigned_int",
          "i4": "int", "u8": "vtktypeuint64", "i8": "vtktypeint64", "f4": "float", "f8": "double"}
#: Numbers a point of attributes whose line does not say it, and all attributes.
_WIDTHS = {"VECTORS": 3, "NORMALS": 3, "TENSORS": 9, "TENSORS6": 6, "GLOBAL_IDS": 1, "PEDIGREE_IDS": 1, "EDGE_FLAGS": 1}
_ATTRIBUTES = (*_WIDTHS, "SCALARS", "COLOR_SCALARS", "LOOKUP_TABLE", "TEXTURE_COORDINATES")


class LegacyFile:
    """A place in a legacy file, which words and arrays are read from."""

    def __init__(self, data: bytes) -> None:
        header = _HEADER.match(data)
        if header is None:
            raise MeshError("damaged: no header of a VTK file, which ends with ASCII or BINARY; check that the file is "
                            "what its name says")
        self.data, self.at = data, header.end()
        self.version, self.binary = int(header[1]), header[2].upper() == b"BINARY"
        self._begins: IntArray | None = None  # of all words of a text file, once they are needed

    def line(self) -> list[str]:
        """The words of the next line that is not empty; none at the end."""
        found = _LINE.match(self.data, self.at)
        assert found is not None
        self.at = found.end()
        return found[1].decode("utf-8", "replace").split()

    def skip_metadata(self) -> None:
        """Go behind the empty line that ends a METADATA block."""
        end = re.compile(rb"\n[ \t\r]*\n|\Z").search(self.data, self.at - 1)
        assert end is not None
        self.at = end.end()

    def array(self, count: int, name: str) -> NDArray[Any]:
        """The next `count` numbers of a type."""
        kind = _TYPES.get(name.lower())
        if kind is None:
            raise MeshError(f"its data of type {name[:20]!a} are not read; write numbers")
        rest = len(self.data) - self.at
        if not self.binary:
            check_complete(0 <= 2 * count - 1 <= rest or count == 0, f"{rest} bytes", f"{count} numbers")
            wide = {"bit": "u1", "vtkidtype": "i8"}.get(name.lower(), kind)
            return numbers_of(self._words(count), wide)
        size = (count + 7) // 8 if kind == "bit" else count * int(kind[1])
        check_complete(0 <= size <= rest, f"{rest} bytes", f"{count} numbers")
        block = self.data[self.at : self.at + size]
        self.at += size
        if kind == "bit":
            return np.unpackbits(np.frombuffer(block, np.uint8))[:count]
        found = np.frombuffer(block, f">{kind}")
        return found.astype("i8" if name.lower() == "vtkidtype" else kind)

    def _words(self, count: int) -> list[bytes]:
        """The next words of a text file."""
        if self._begins is None:
            space = np.frombuffer(b" " + self.data, np.uint8) <= 32
            self._begins = np.flatnonzero(space[:-1] & ~space[1:])
        first = int(np.searchsorted(self._begins, self.at))
        begins = self._begins[first : first + count + 1]
        check_complete(len(begins) >= count, f"{len(begins)} words", f"{count} numbers")
        begin, self.at = self.at, int(begins[count]) if len(begins) > count else len(self.data)
        return self.data[begin : self.at].split()

    def skip_strings(self, count: int) -> None:
        """Skip strings: lines of text, or in binary a length of one to eight bytes before each."""
        check_complete(0 <= count <= len(self.data) - self.at, f"{len(self.data) - self.at} bytes", f"{count} strings")
        for _ in range(count):
            if not self.binary:  # a string may be empty
                self.at = 1 + self.data.find(b"\n", self.at) or len(self.data)
                continue
            check_complete(self.at < len(self.data), "0 bytes", f"{count} strings")
            width = {3: 1, 2: 2, 1: 4, 0: 8}[self.data[self.at] >> 6]
            length = int.from_bytes(self.data[self.at : self.at + width], "big") & ((1 << (8 * width - 2)) - 1)
            self.at += width + length

    def cells(self, count: int, size: int) -> Polygons:
        """Read cells; of the two numbers in their line, the meaning changed with version 5."""
        if self.version < 5:
            return _counted(self.array(size, "int"), count)
        ends, corners = (self.array(length, self._typed(word)) for length, word in ((count, "OFFSETS"),
                                                                                     (size, "CONNECTIVITY")))
        return polygons(corners, ends[1:], first=int(ends[0]) if len(ends) else 0)

    def _typed(self, word: str) -> str:
        """The type of the array that a line of two words announces."""
        words = self.line()
        if len(words) != 2 or words[0].upper() != word:
            raise MeshError(f"damaged: {' '.join(words)[:40]!a} where {word} is expected; write the file anew")
        return words[1]


def numbers_of(words: Iterable[str | bytes], kind: str) -> NDArray[Any]:
    """Words as numbers of a type; a ValueError if one is not one, an OverflowError if the type does not hold it."""
    if kind[0] == "f":
        return np.fromiter(map(float, words), dtype=np.float64).astype(kind)
    whole = np.fromiter(map(int, words), dtype=np.uint64 if kind == "u8" else np.int64)
    if (whole.astype(kind) != whole).any():
        raise OverflowError(f"a number is out of the range of {np.dtype(kind).name}")
    return whole.astype(kind)


def _counted(numbers: IntArray, count: int) -> Polygons:
    """Cells that each begin with the number of their corners."""
    numbers = numbers.astype(np.int64)
    if len(numbers) == 4 * count and (numbers[::4] == 3).all():
        return Polygons(numbers.reshape(-1, 4)[:, 1:].ravel(), np.full(count, 3))
    heads: list[int] = []
    at = 0
    while at < len(numbers) and len(heads) < count:
        heads.append(at)
        at += 1 + max(int(numbers[at]), 0)
    if at != len(numbers) or len(heads) != count:
        raise MeshError(f"damaged: {len(numbers)} numbers do not hold {count} cells; write the file anew")
    return Polygons(np.delete(numbers, heads), numbers[heads])


def polygons(corners: IntArray, ends: IntArray, first: int = 0) -> Polygons:
    """Make polygons of all corners and the places where each one ends, which must rise to the number of corners."""
    bounds = np.concatenate([[first], ends]).astype(np.int64)
    sizes = np.diff(bounds)
    if first != 0 or (sizes < 0).any() or bounds[-1] != len(corners):
        raise MeshError("damaged: the offsets of polygons do not rise from 0 to the number of their corners; write the "
                        "file anew")
    return Polygons(corners.astype(np.int64), sizes)


def read(path: Path) -> RawMesh:
    """Points, polygons and point data of a legacy file."""
    file = LegacyFile(path.read_bytes())
    v, faces, count, point_data = None, None, 0, None
    kept: dict[str, NDArray[Any]] = {}
    while words := file.line():
        match [words[0].upper(), *words[1:]]:
            case ["DATASET", kind]:
                if kind.upper() != "POLYDATA":
                    raise MeshError(f"it holds {kind[:30]!a} but only POLYDATA is read; extract the surface")
            case ["POINTS", n, kind]:
                v = file.array(3 * int(n), kind).reshape(-1, 3)
            case ["POLYGONS", n, size]:
                faces = file.cells(int(n), int(size))
            case ["TRIANGLE_STRIPS", _, _]:
                raise MeshError("its triangle strips are not read; write triangles, as vtkTriangleFilter does")
            case ["VERTICES" | "LINES", n, size]:
                file.cells(int(n), int(size))
            case ["METADATA"]:
                file.skip_metadata()
            case ["POINT_DATA" | "CELL_DATA" as where, n]:
                count, point_data = int(n), where == "POINT_DATA"
            case ["FIELD", _, n]:
                found = _field(file, int(n))
                if point_data:
                    kept |= {name: values for name, values in found.items() if len(values) == count}
            case [kind, name, *more] if point_data is not None and kind in _ATTRIBUTES:
                values = _attribute(file, kind, more, count)
                if point_data and kind != "LOOKUP_TABLE":
                    kept[unquote(name)] = values
            case _:
                raise MeshError(f"damaged: {' '.join(words)[:40]!a} where a keyword is expected; write the file anew")
    return raw_mesh(v, faces, kept)


def raw_mesh(v: NDArray[Any] | None, faces: Polygons | None, point_data: dict[str, NDArray[Any]]) -> RawMesh:
    """What a file of polygons holds; a MeshError where it has none."""
    if v is None or faces is None or len(faces.sizes) == 0:
        raise MeshError("it holds no polygons: a point cloud, lines or another kind of data; give a closed triangle "
                        "mesh")
    kept = {name: values for name, values in point_data.items() if len(values) == len(v)}
    return RawMesh(v, faces, {"point_data": kept} if kept else {})


def _field(file: LegacyFile, count: int) -> dict[str, NDArray[Any]]:
    """The arrays of numbers of a field, by name."""
    arrays = {}
    for _ in range(count):
        words = file.line()
        while words == ["METADATA"]:
            file.skip_metadata()
            words = file.line()
        name, width, length, kind = words
        if kind.lower() in ("string", "utf8_string"):
            file.skip_strings(int(width) * int(length))
            continue
        values = file.array(int(width) * int(length), kind)
        arrays[unquote(name)] = values if width == "1" else values.reshape(int(length), int(width))
    return arrays


def _attribute(file: LegacyFile, kind: str, more: list[str], count: int) -> NDArray[Any]:
    """The values of an attribute of the points or cells."""
    if kind == "SCALARS":
        width = int(more[1]) if len(more) > 1 else 1
        if file.line()[:1] != ["LOOKUP_TABLE"]:
            raise MeshError("damaged: scalars without the name of their LOOKUP_TABLE; write the file anew")
        type_name = more[0]
    elif kind == "COLOR_SCALARS":
        width, type_name = int(more[0]), "unsigned_char" if file.binary else "float"
    elif kind == "LOOKUP_TABLE":
        return file.array(4 * int(more[0]), "unsigned_char" if file.binary else "float")
    elif kind == "TEXTURE_COORDINATES":
        width, type_name = int(more[0]), more[1]
    else:
        width, type_name = _WIDTHS[kind], more[0]
    values = file.array(width * count, type_name)
    if kind == "COLOR_SCALARS" and not file.binary:
        values = np.floor(255 * values + 0.5).astype(np.uint8)
    return values if width == 1 else values.reshape(count, width)


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write version 3.0 in binary, the mark as its title, and the arrays of ``point_data`` that have a row a vertex."""
    cells = np.column_stack([np.full(len(f), 3), f]).astype(">i4")
    kept = fitting(metadata, len(v))
    with path.open("wb") as file:
        file.write(f"# vtk DataFile Version 3.0\n{metadata.get('mark', 'igl_spheremap')}\nBINARY\nDATASET POLYDATA\n"
                   f"POINTS {len(v)} double\n".encode())
        file.write(v.astype(">f8").tobytes())
        file.write(f"\nPOLYGONS {len(f)} {cells.size}\n".encode() + cells.tobytes() + b"\n")
        if kept:
            file.write(f"POINT_DATA {len(v)}\nFIELD FieldData {len(kept)}\n".encode())
        for name, values in kept.items():
            kind, width = values.dtype.str[1:], values.size // max(len(v), 1)
            file.write(f"{quote(name, safe='', errors='replace')} {width} {len(v)} {_NAMES[kind]}\n".encode())
            file.write(values.astype(f">{kind}").tobytes() + b"\n")


def fitting(metadata: Metadata, n: int) -> dict[str, NDArray[Any]]:
    """The arrays of numbers among the point data that have a name and n rows."""
    arrays = {str(name): np.asarray(values) for name, values in metadata.get("point_data", {}).items()}
    return {name: values for name, values in arrays.items()
            if name and values.ndim in (1, 2) and len(values) == n and values.dtype.str[1:] in _NAMES}
