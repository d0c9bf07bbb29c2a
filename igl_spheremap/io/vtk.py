"""VTK's legacy files (.vtk), versions 3.0 to 5.1, as text and in binary; written in binary doubles, which are exact.

Polygons and point data are kept, of unstructured grids without volumes, too; points without faces, lines, cell data,
field data and texts are skipped. VTK's own reader crashes on damaged files, or returns memory that it has not filled
(benchmarks/tried.md).
"""

from __future__ import annotations

import re
from pathlib import Path
from urllib.parse import quote, unquote

import numpy as np

from ..errors import MeshError
from ..mesh.arrays import AnyArray, FloatArray, IntArray
from ..mesh_repair.polygons import counted_corners
from .reading import Bytes, check_complete
from .records import Metadata, NamedArrays, Polygons, RawMesh, ending

_HEADER = re.compile(
    rb"# vtk DataFile Version (\d+)\.\d+[^\n]*\n[^\n]*\n\s*(ASCII|BINARY)\s*?\n", re.IGNORECASE
)
_LINE = re.compile(rb"\s*([^\r\n]*)(?:\r?\n|\r|\Z)")
_EMPTY_LINE = re.compile(rb"\n[ \t\r]*\n|\Z")
#: The first name of a type is the one that is written; identifiers have 4 bytes in binary.
_TYPES = {
    "unsigned_char": "u1", "signed_char": "i1", "char": "i1", "unsigned_short": "u2", "short": "i2",
    "unsigned_int": "u4", "int": "i4", "vtktypeuint64": "u8", "unsigned_long": "u8", "vtktypeint64": "i8",
    "long": "i8", "vtkidtype": "i8", "float": "f4", "double": "f8",
}  # fmt: skip
_TEXTS = ("string", "utf8_string", "vtkstring")
_NAMES = {kind: name for name, kind in reversed(_TYPES.items())}
EXTRACT = (
    "extract its surface by PyVista: read(FILE).extract_surface().triangulate().save('surface.vtk')"
)
SAVE = "write it anew by PyVista: read(FILE).save('surface.vtk')"
#: Numbers a point of attributes whose line does not say it.
_WIDTHS = {"VECTORS": 3, "NORMALS": 3, "TENSORS": 9, "GLOBAL_IDS": 1, "PEDIGREE_IDS": 1}


class LegacyFile(Bytes):
    """A place in a legacy file, which words and arrays are read from."""

    def __init__(self, data: bytes) -> None:
        header = _HEADER.match(data)
        if header is None:
            raise MeshError(
                "damaged: no header of a VTK file, which ends with ASCII or BINARY; check that the file is "
                "what its name says"
            )
        super().__init__(data, header.end())
        self.version, self.binary = int(header[1]), header[2].upper() == b"BINARY"
        self.colour = "float"  # the type of the parts of colours
        if self.binary:
            self.colour = "unsigned_char"

    def line(self) -> list[str]:
        """The words of the next line that is not empty; none at the end."""
        found = _LINE.match(self.data, self.at)
        assert found is not None
        self.at = found.end()
        return found[1].decode("utf-8", "replace").split()

    def skip_metadata(self) -> None:
        """Go behind the empty line that ends a METADATA block."""
        end = _EMPTY_LINE.search(self.data, self.at - 1)
        assert end is not None
        self.at = end.end()

    def numbers(self, count: int, name: str) -> AnyArray:
        """The next `count` numbers of a type; none of texts, which are skipped."""
        kind = name.lower()
        if kind in _TEXTS:
            self._skip_texts(count)
            return np.empty(0)
        if kind == "bit" and self.binary:
            return np.unpackbits(self.numbers(-(-count // 8), "unsigned_char"))[:count]
        if kind == "bit":
            kind = "unsigned_char"
        if kind not in _TYPES:
            raise MeshError(f"its data of type {name[:20]!a} are not read; write numbers")
        if self.binary:
            stored = _TYPES[kind]
            if kind == "vtkidtype":
                stored = "i4"
            return self.array(f">{stored}", count).astype(_TYPES[kind])
        rest = len(self.data) - self.at
        # a digit and the space behind it
        check_complete(0 <= 2 * count <= rest + 1, f"{rest} bytes", f"{count} numbers")
        try:
            return _numbers(self._words(count), _TYPES[kind])
        except (ValueError, OverflowError):
            raise MeshError(
                f"damaged: what follows {name!a} is not {count} numbers of that type; write the file anew"
            ) from None

    def _words(self, count: int) -> list[bytes]:
        """The next words, fewer at the end; a part of the text is split that is about as long as they are."""
        size = 16 * (count + 1)
        while True:
            end = self.at + size
            words = self.data[self.at : end].split(None, count)
            if len(words) > count or end >= len(self.data):
                break
            size *= 2
        self.at = min(end, len(self.data))
        if len(words) > count:
            self.at -= len(words.pop())
        return words

    def _skip_texts(self, count: int) -> None:
        """Go behind texts: a line each, or behind their lengths, whose first two bits say how long these are."""
        for _ in range(count):
            if self.binary:
                first = self.number("u1")
                more = self.take((8 >> (first >> 6)) - 1)
                size = int.from_bytes(bytes([first & 63]) + more, "big")
            else:
                size = self.data.find(b"\n", self.at) + 1 - self.at
            self.take(size)

    def cells(self, count: int, size: int) -> Polygons:
        """Read cells; version 5 changed the meaning of the two numbers in their line."""
        if self.version < 5:
            faces = counted_corners(self.numbers(size, "int"))
            if faces is None or len(faces[1]) != count:
                raise MeshError(
                    f"damaged: {size} numbers do not hold {count} cells; write the file anew"
                )
            return Polygons(*faces)
        ends, corners = (
            self.numbers(length, self._typed(word)).astype(np.int64)
            for length, word in ((count, "OFFSETS"), (size, "CONNECTIVITY"))
        )
        if ends[0] != 0:
            raise MeshError(
                "damaged: the offsets of cells do not begin with 0; write the file anew"
            )
        return ending(corners, ends[1:])

    def _typed(self, word: str) -> str:
        """The type of the array that a line of two words announces."""
        words = self.line()
        if len(words) != 2 or words[0].upper() != word:
            raise MeshError(
                f"damaged: {' '.join(words)[:40]!a} where {word} is expected; write the file anew"
            )
        return words[1]


def surface_cells(cells: Polygons, types: IntArray) -> Polygons:
    """The polygons among the cells of a grid; grids with volumes are refused.

    By VTK's numbers vertices, lines and strips come before 5, polygons are 5, 7, 9, and 8 with its corners row by row.
    """
    kept = np.isin(types, (5, 7, 8, 9))
    volumes = ~kept & ~np.isin(types, (0, 1, 2, 3, 4))
    if len(types) != len(cells.sizes) or volumes.any():
        found = ", ".join(map(str, np.unique(types[volumes]).tolist())) or "fewer than its cells"
        raise MeshError(f"it holds cells that are no polygons (VTK's types {found}); {EXTRACT}")
    corners, ends = cells.corners.copy(), np.cumsum(cells.sizes)
    pixels = ends[types == 8]
    corners[pixels - 1], corners[pixels - 2] = cells.corners[pixels - 2], cells.corners[pixels - 1]
    return Polygons(corners[np.repeat(kept, cells.sizes)], cells.sizes[kept])


def _numbers(words: list[bytes], kind: str) -> AnyArray:
    """Words as numbers of a type; a ValueError if one is not one, an OverflowError if the type does not hold it."""
    if kind[0] == "f":
        return np.fromiter(map(float, words), dtype=np.float64).astype(kind)
    whole = np.fromiter(map(int, words), dtype=np.uint64 if kind == "u8" else np.int64)
    if (whole.astype(kind) != whole).any():
        raise OverflowError(f"a number is out of the range of {np.dtype(kind).name}")
    return whole.astype(kind)


def surface(v: AnyArray | None, faces: Polygons | None, point_data: NamedArrays) -> RawMesh:
    """A mesh with those arrays that have a row a vertex; without polygons it is refused."""
    if v is None or faces is None or len(faces.sizes) == 0:
        raise MeshError(
            "it holds no polygons: a point cloud, lines or another kind of data; give a closed triangle "
            "mesh"
        )
    metadata = {}
    if fit := {name: values for name, values in point_data.items() if len(values) == len(v)}:
        metadata["point_data"] = fit
    return RawMesh(v, faces, metadata)


def read(path: Path) -> RawMesh:
    """Points, polygons and point data of a legacy file."""
    file = LegacyFile(path.read_bytes())
    v, faces, cells, count, point_data = None, None, None, 0, False
    kept: NamedArrays = {}
    while words := file.line():
        found: NamedArrays = {}
        match [words[0].upper(), *words[1:]]:
            case ["DATASET", kind]:
                if kind.upper() not in ("POLYDATA", "UNSTRUCTURED_GRID"):
                    raise MeshError(f"it holds {kind[:30]!a}, no polygons; {EXTRACT}")
            case ["POINTS", n, kind]:
                v = file.numbers(3 * int(n), kind).reshape(-1, 3)
            case ["POLYGONS", n, size]:
                faces = file.cells(int(n), int(size))
            case ["CELLS", n, size]:
                cells = file.cells(int(n), int(size))
            case ["CELL_TYPES", n] if cells is not None:
                faces = surface_cells(cells, file.numbers(int(n), "int"))
            case ["TRIANGLE_STRIPS", _, _]:
                raise MeshError(
                    "its triangle strips are not read; write triangles, as vtkTriangleFilter does"
                )
            case ["VERTICES" | "LINES", n, size]:
                file.cells(int(n), int(size))
            case ["METADATA"]:
                file.skip_metadata()
            case ["POINT_DATA" | "CELL_DATA" as where, n]:
                count, point_data = int(n), where == "POINT_DATA"
            case ["FIELD", _, n]:
                found = _field(file, int(n))
            case ["LOOKUP_TABLE", _, n]:
                file.numbers(4 * int(n), file.colour)
            case ["COLOR_SCALARS", name, width]:
                parts = _rows(file, count, file.colour, width)
                if not file.binary:
                    parts = np.floor(255 * parts + 0.5).astype(np.uint8)
                found = {name: parts}
            case ["SCALARS", name, kind, *width]:
                if file.line()[:1] != ["LOOKUP_TABLE"]:
                    raise MeshError(
                        "damaged: scalars without the name of their LOOKUP_TABLE; write the file anew"
                    )
                found = {name: _rows(file, count, kind, *width[:1])}
            case ["TEXTURE_COORDINATES", name, width, kind]:
                found = {name: _rows(file, count, kind, width)}
            case [attribute, name, kind] if attribute in _WIDTHS:
                found = {name: _rows(file, count, kind, _WIDTHS[attribute])}
            case _:
                raise MeshError(
                    f"damaged: {' '.join(words)[:40]!a} where a keyword is expected; write the file anew"
                )
        if point_data:
            kept |= {unquote(name): values for name, values in found.items()}
    return surface(v, faces, kept)


def _rows(file: LegacyFile, count: int, kind: str, width: str | int = 1) -> AnyArray:
    """The next `count` rows of numbers; one number a row needs no second dimension."""
    values = file.numbers(int(width) * count, kind)
    if int(width) == 1:
        return values
    return values.reshape(count, int(width))


def _field(file: LegacyFile, count: int) -> NamedArrays:
    """The arrays of a field, by name."""
    arrays = {}
    for _ in range(count):
        words = file.line()
        while words == ["METADATA"]:
            file.skip_metadata()
            words = file.line()
        name, width, length, kind = words
        arrays[name] = _rows(file, int(length), kind, width)
    return arrays


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write version 3.0 in binary, the mark as its title, and the arrays of ``point_data`` that have a row a vertex."""
    cells = np.column_stack([np.full(len(f), 3), f]).astype(">i4")
    arrays = {
        str(name): np.asarray(values) for name, values in metadata.get("point_data", {}).items()
    }
    kept = {
        name: values
        for name, values in arrays.items()
        if name
        and values.ndim in (1, 2)
        and len(values) == len(v)
        and values.dtype.str[1:] in _NAMES
    }
    with path.open("wb") as file:
        file.write(
            f"# vtk DataFile Version 3.0\n{metadata.get('mark', 'igl_spheremap')}\nBINARY\nDATASET POLYDATA\n"
            f"POINTS {len(v)} double\n".encode()
        )
        file.write(v.astype(">f8").tobytes())
        file.write(f"\nPOLYGONS {len(f)} {cells.size}\n".encode() + cells.tobytes() + b"\n")
        if kept:
            file.write(f"POINT_DATA {len(v)}\nFIELD FieldData {len(kept)}\n".encode())
        for name, values in kept.items():
            kind, width = values.dtype.str[1:], values.size // max(len(v), 1)
            file.write(
                f"{quote(name, safe='', errors='replace')} {width} {len(v)} {_NAMES[kind]}\n".encode()
            )
            file.write(values.astype(f">{kind}").tobytes() + b"\n")
