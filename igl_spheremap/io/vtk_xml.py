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
from numpy.typing import NDArray

from ..errors import MeshError, printable
from .reading import check_complete, check_expansion
from .records import Polygons, RawMesh, ending
from .vtk import EXTRACT, SAVE, surface_cells

_TYPES = {f"{name}{8 * size}": f"{kind}{size}" for name, kind, sizes in (
    ("Int", "i", (1, 2, 4, 8)), ("UInt", "u", (1, 2, 4, 8)), ("Float", "f", (4, 8)),
) for size in sizes}  # fmt: skip
#: By VTK's names of what packed the blocks: what makes an object that unpacks one.
_UNPACKERS: dict[str, Callable[[], Any]] = {
    "vtkZLibDataCompressor": zlib.decompressobj,
    "vtkLZMADataCompressor": lambda: lzma.LZMADecompressor(memlimit=1 << 28),
}


@dataclass
class _Arrays:
    """What all arrays of a file share."""

    order: Literal["<", ">"]
    header: np.dtype[Any]  # of the counts of bytes before blocks
    packer: str  # the name of what packed them, if they are packed
    appended: bytes  # arrays behind the tree
    encoded: bool  # whether these are in base64
    stored: int  # bytes of the file
    expanded: int = 0

    def read(self, element: ElementTree.Element) -> NDArray[Any]:
        """The numbers of a DataArray, a row for each tuple if it has more than one component."""
        kind = np.dtype(_TYPES[element.get("type", "")]).newbyteorder(self.order)
        form = element.get("format", "ascii").lower()
        if form == "appended":
            values = np.frombuffer(
                self._block(self.appended, int(element.get("offset", 0)), self.encoded), kind
            )
        elif form == "binary":
            values = np.frombuffer(
                self._block("".join((element.text or "").split()).encode(), 0, True), kind
            )
        else:
            values = np.array((element.text or "").split(), dtype=kind)
        width = int(element.get("NumberOfComponents", 1))
        return values if width == 1 else values.reshape(-1, width)

    def _block(self, data: bytes, at: int, encoded: bool) -> bytes:
        """The bytes of an array that begins at a place: behind their number, or packed in blocks behind their sizes."""
        size = self.header.itemsize
        if not self.packer:
            count = int(np.frombuffer(_bytes_at(data, at, size, encoded)[0], self.header)[0])
            return _bytes_at(data, at, size + count, encoded)[0][size:]
        if self.packer not in _UNPACKERS:
            packer = printable(self.packer)[:30]
            raise MeshError(f"it is packed by {packer}, which is not read; {SAVE}")
        blocks, whole, _ = np.frombuffer(
            _bytes_at(data, at, 3 * size, encoded)[0], self.header
        ).tolist()
        head, end = _bytes_at(data, at, (3 + blocks) * size, encoded)
        sizes = np.frombuffer(head, self.header)[3:]
        self.expanded += whole * blocks
        check_expansion(self.expanded, self.stored)
        packed, _ = _bytes_at(data, end, int(sizes.sum()), encoded)
        parts, begin = [], 0
        for count in sizes.tolist():
            parts.append(
                _UNPACKERS[self.packer]().decompress(packed[begin : begin + count], max(whole, 1))
            )
            begin += count
        return b"".join(parts)


def _bytes_at(data: bytes, at: int, count: int, encoded: bool) -> tuple[bytes, int]:
    """The next `count` bytes from a place, and where they end; text of base64 is decoded."""
    length = -(-count // 3) * 4 if encoded else count
    check_complete(
        at >= 0 and length >= 0 and at + length <= len(data), f"{len(data) - at} bytes", str(length)
    )
    part = data[at : at + length]
    return (binascii.a2b_base64(part)[:count] if encoded else part), at + length


def read(path: Path) -> RawMesh:
    """Points, polygons and point data of all pieces of a file."""
    root, arrays = _opened(path.read_bytes())
    pieces = [_piece(element, arrays) for element in root.iter("Piece")]
    cells = [faces for _, faces, _ in pieces]
    if sum(len(faces.sizes) for faces in cells) == 0:
        raise MeshError(
            "it holds no polygons: a point cloud, lines or another kind of data; give a closed triangle mesh"
        )
    first = np.cumsum([0] + [len(v) for v, _, _ in pieces])[:-1]
    corners = [faces.corners + start for faces, start in zip(cells, first, strict=True)]
    polygons = Polygons(np.concatenate(corners), np.concatenate([faces.sizes for faces in cells]))
    names = set.intersection(*({*data} for _, _, data in pieces))
    kept = {name: np.concatenate([data[name] for _, _, data in pieces]) for name in sorted(names)}
    return RawMesh(
        np.concatenate([v for v, _, _ in pieces]), polygons, {"point_data": kept} if kept else {}
    )


def read_scalars(path: Path) -> dict[str, NDArray[Any]]:
    """The point data."""
    return dict(read(path).metadata.get("point_data", {}))


def _opened(data: bytes) -> tuple[ElementTree.Element, _Arrays]:
    """The tree of a file, without what is appended to it, and how its arrays are stored."""
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
    order: Literal["<", ">"] = ">" if root.get("byte_order") == "BigEndian" else "<"
    header = np.dtype({"UInt32": "u4", "UInt64": "u8"}[root.get("header_type", "UInt32")])
    block = root.find("AppendedData")
    encoded = block is not None and block.get("encoding") == "base64"
    return root, _Arrays(order, header.newbyteorder(order), packer, appended, encoded, len(data))


def _piece(
    piece: ElementTree.Element, arrays: _Arrays
) -> tuple[NDArray[Any], Polygons, dict[str, NDArray[Any]]]:
    """Points, polygons and point data of a piece."""
    points = piece.find("Points/DataArray")
    if points is None:
        return (
            np.empty((0, 3)),
            Polygons(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)),
            {},
        )
    v = arrays.read(points)
    strips = piece.get("NumberOfStrips", "0")
    if strips != "0":
        raise MeshError(f"its {printable(strips)[:10]} triangle strips are not read; {EXTRACT}")
    found: dict[str, NDArray[Any]] = {}
    for element in piece.iterfind("Polys/DataArray"):
        found[element.get("Name", "")] = arrays.read(element)
    for element in piece.iterfind("Cells/DataArray"):
        found[element.get("Name", "")] = arrays.read(element)
    none = np.empty(0, dtype=np.int64)
    polygons = ending(
        *(found.get(name, none).astype(np.int64) for name in ("connectivity", "offsets"))
    )
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
