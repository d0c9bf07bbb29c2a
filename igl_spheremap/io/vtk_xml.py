"""VTK's XML files of polygons (.vtp) and of unstructured grids (.vtu), as text, in base64 or raw, packed or not.

They are read only. As of legacy files, polygons and point data are kept.
"""

from __future__ import annotations

import binascii
import lzma
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal
from xml.etree import ElementTree

import numpy as np

from ..errors import MeshError, printable
from ..mesh.arrays import AnyArray
from .reading import Bytes, check_expansion
from .records import NamedArrays, Polygons, RawMesh, ending
from .vtk import EXTRACT, SAVE, surface, surface_cells

_TYPES = {f"{name}{8 * size}": f"{kind}{size}" for name, kind, sizes in (
    ("Int", "i", (1, 2, 4, 8)), ("UInt", "u", (1, 2, 4, 8)), ("Float", "f", (4, 8)),
) for size in sizes}  # fmt: skip
#: Makers of objects that unpack a block, by VTK's names of the compressors.
_UNPACKERS: dict[str, Callable[[], Any]] = {
    "vtkZLibDataCompressor": zlib.decompressobj,
    "vtkLZMADataCompressor": lambda: lzma.LZMADecompressor(memlimit=1 << 28),
}


class _Stored(Bytes):
    """Storage of arrays: bytes, or text of base64, which is decoded."""

    def __init__(self, data: bytes, at: int, encoded: bool) -> None:
        super().__init__(data, at)
        self.encoded = encoded

    def take(self, size: int) -> bytes:
        """The next bytes; of base64 all characters that have a part in them."""
        if not self.encoded:
            return super().take(size)
        return binascii.a2b_base64(super().take(-(-size // 3) * 4))[:size]


@dataclass
class _Arrays:
    """Common facts of all arrays of a file."""

    order: Literal["<", ">"]
    header: np.dtype[Any]  # of the counts of bytes before blocks
    packer: str  # the name of their compressor, if they are packed
    appended: bytes  # arrays behind the tree
    encoded: bool  # whether these are in base64
    stored: int  # bytes of the file
    expanded: int = 0

    def read(self, element: ElementTree.Element) -> AnyArray:
        """The numbers of a DataArray, a row for each tuple if it has more than one component."""
        kind = np.dtype(_TYPES[element.get("type", "")]).newbyteorder(self.order)
        words = element.findtext(".", "").split()
        match element.get("format", "ascii").lower():
            case "appended":
                source = _Stored(self.appended, int(element.get("offset", 0)), self.encoded)
                values = np.frombuffer(self._content(source), kind)
            case "binary":
                source = _Stored("".join(words).encode(), 0, True)
                values = np.frombuffer(self._content(source), kind)
            case _:
                values = np.array(words, dtype=kind)
        width = int(element.get("NumberOfComponents", 1))
        if width == 1:
            return values
        return values.reshape(-1, width)

    def _content(self, source: _Stored) -> bytes:
        """The bytes of an array: behind their number, or packed in blocks behind their sizes."""
        size, start = self.header.itemsize, source.at
        if not self.packer:
            count = source.number(self.header)
            source.at = start
            return source.take(size + count)[size:]
        if self.packer not in _UNPACKERS:
            packer = printable(self.packer)[:30]
            raise MeshError(f"it is packed by {packer}, which is not read; {SAVE}")
        blocks, whole, _ = source.array(self.header, 3).tolist()
        source.at = start
        sizes = source.array(self.header, 3 + blocks)[3:]
        self.expanded += whole * blocks
        check_expansion(self.expanded, self.stored)
        packed, unpacker = Bytes(source.take(int(sizes.sum()))), _UNPACKERS[self.packer]
        return b"".join(
            unpacker().decompress(packed.take(count), max(whole, 1)) for count in sizes.tolist()
        )


def read(path: Path) -> RawMesh:
    """Points, polygons and point data of all pieces of a file."""
    root, arrays = _opened(path.read_bytes())
    pieces = [
        _piece(element, points, arrays)
        for element in root.iter("Piece")
        if (points := element.find("Points/DataArray")) is not None
    ]
    if not pieces:
        return surface(None, None, {})
    first = np.cumsum([0] + [len(v) for v, _, _ in pieces])[:-1]
    corners = [faces.corners + start for (_, faces, _), start in zip(pieces, first, strict=True)]
    polygons = Polygons(
        np.concatenate(corners), np.concatenate([faces.sizes for _, faces, _ in pieces])
    )
    names = set.intersection(*({*data} for _, _, data in pieces))
    kept = {name: np.concatenate([data[name] for _, _, data in pieces]) for name in sorted(names)}
    return surface(np.concatenate([v for v, _, _ in pieces]), polygons, kept)


def _opened(data: bytes) -> tuple[ElementTree.Element, _Arrays]:
    """The tree of a file, without the appended data, and the storage of its arrays."""
    if b"<!ENTITY" in data:
        raise MeshError("its XML defines entities, which VTK's files don't; write it anew")
    begin = data.find(b"<AppendedData")
    tree, appended = data, b""
    if begin >= 0:
        at = data.index(b"_", begin) + 1
        tree, appended = data[:at] + b"</AppendedData></VTKFile>", data[at:]
    root = ElementTree.fromstring(tree)
    kind, packer = root.get("type", ""), root.get("compressor", "")
    if kind not in ("PolyData", "UnstructuredGrid"):
        raise MeshError(f"it holds {printable(kind)[:30]!a}, no polygons; {EXTRACT}")
    order: Literal["<", ">"] = "<"
    if root.get("byte_order") == "BigEndian":
        order = ">"
    header = np.dtype({"UInt32": "u4", "UInt64": "u8"}[root.get("header_type", "UInt32")])
    block = root.find("AppendedData")
    encoded = block is not None and block.get("encoding") == "base64"
    return root, _Arrays(order, header.newbyteorder(order), packer, appended, encoded, len(data))


def _piece(
    piece: ElementTree.Element, points: ElementTree.Element, arrays: _Arrays
) -> tuple[AnyArray, Polygons, NamedArrays]:
    """Points, polygons and point data of a piece."""
    v = arrays.read(points)
    strips = piece.get("NumberOfStrips", "0")
    if strips != "0":
        raise MeshError(f"its {printable(strips)[:10]} triangle strips are not read; {EXTRACT}")
    found = {
        name: np.empty(0, dtype=np.int64) for name in ("connectivity", "offsets")
    }  # of no polygons
    for element in (*piece.iterfind("Polys/DataArray"), *piece.iterfind("Cells/DataArray")):
        found[element.get("Name", "")] = arrays.read(element)
    polygons = ending(found["connectivity"].astype(np.int64), found["offsets"].astype(np.int64))
    if "types" in found:
        polygons = surface_cells(polygons, found["types"])
    data = {
        name: values
        for element in piece.iterfind("PointData/DataArray")
        if (name := element.get("Name", ""))
        and element.get("type") in _TYPES
        and len(values := arrays.read(element)) == len(v)
    }
    return v, polygons, data
