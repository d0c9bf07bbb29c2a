"""VTK's XML files of polygons (.vtp): arrays as text, base64 or appended, plain or packed by zlib.

Written in base64 of doubles, which are exact. Triangles and point data are kept, as of `.vtk` files.
"""

from __future__ import annotations

import base64
import re
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from ..errors import MeshError
from ..mesh.arrays import FloatArray, IntArray
from .reading import check_complete, check_expansion
from .records import Metadata, RawMesh
from .vtk import fitting, numbers_of, polygons, raw_mesh

_TYPES = {"Int8": "i1", "UInt8": "u1", "Int16": "i2", "UInt16": "u2", "Int32": "i4", "UInt32": "u4", "Int64": "i8",
          "UInt64": "u8", "Float32": "f4", "Float64": "f8"}
_NAMES = {code: name for name, code in _TYPES.items()}
_APPENDED = re.compile(rb"<AppendedData\b([^>]{0,99})>\s{0,99}_")
_END = b"</AppendedData>"
_NO_XML = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


@dataclass
class XmlFile:
    """The properties of a file by which its arrays are read."""

    order: str  # of bytes, "<" or ">"
    header: np.dtype[Any]  # of the sizes before a block of data
    packed: bool
    appended: bytes
    encoded: bool  # whether the appended data are base64
    stored: int  # bytes of the file
    expanded: int = 0  # bytes of the arrays that were read: several may be the same bytes of the file

    def array(self, element: ElementTree.Element) -> NDArray[Any]:
        """The numbers of a DataArray, with a row for each tuple if it has several components."""
        kind = f"{self.order}{_TYPES[element.get('type', '')]}"
        text = element.text or ""
        match element.get("format"):
            case "ascii":
                flat = numbers_of(text.split(), kind[1:])
            case "binary":
                flat = np.frombuffer(self._block("".join(text.split()).encode("ascii"), 0, encoded=True), kind)
            case "appended":
                flat = np.frombuffer(self._block(self.appended, int(element.get("offset", "")), self.encoded), kind)
            case other:
                raise MeshError(f"damaged: an array of the format {other!a}; write the file anew")
        self.expanded += flat.nbytes
        check_expansion(self.expanded, self.stored)
        width = int(element.get("NumberOfComponents", "1"))
        native = flat.astype(flat.dtype.newbyteorder("="))
        return native if width == 1 else native.reshape(-1, width)

    def _block(self, data: bytes, at: int, encoded: bool) -> bytes:
        """Read the block that begins at a byte: its size or sizes, then its content."""

        def take(at: int, size: int) -> bytes:
            """Bytes from the place `at` of the data, which are base64 if they are encoded."""
            check_complete(at >= 0 and 0 <= length(size) <= len(data) - at, f"{len(data) - at} bytes", f"{size}")
            part = data[at : at + length(size)]
            return base64.b64decode(part, validate=True)[:size] if encoded else part

        def length(size: int) -> int:
            return -(-size // 3) * 4 if encoded else size

        word = self.header.itemsize
        first = int(np.frombuffer(take(at, word), self.header)[0])
        if self.packed:
            return self._unpack(take, length, at, first)
        apart = encoded and data[at : at + length(word)].endswith(b"=" * (-word % 3))  # the size is encoded by itself
        return take(at + length(word), first) if apart else take(at, word + first)[word:]

    def _unpack(self, take: Callable[[int, int], bytes], length: Callable[[int], int], at: int, count: int) -> bytes:
        """Unpack a block of pieces, behind their number, their size, the size of the last one and the packed sizes."""
        head = self.header.itemsize * (3 + count)
        _, size, last, *stored = map(int, np.frombuffer(take(at, head), self.header))
        sizes = [size] * count
        if last and count:
            sizes[-1] = last
        check_expansion(sum(sizes), self.stored)
        packed, pieces, begin = take(at + length(head), sum(stored)), [], 0
        for whole, part in zip(sizes, stored, strict=True):
            pieces.append(zlib.decompressobj().decompress(packed[begin : begin + part], whole + 1))
            check_complete(len(pieces[-1]) == whole, f"{len(pieces[-1])} bytes", f"{whole}")
            begin += part
        return b"".join(pieces)


def read(path: Path) -> RawMesh:
    """Points, polygons and point data; several pieces become one mesh."""
    data = path.read_bytes()
    found, appended = _APPENDED.search(data), b""
    stored = len(data)
    if found is not None:
        end = data.rfind(_END)
        check_complete(end >= found.end(), "0 bytes", "appended data")
        appended, data = data[found.end() : end].rstrip(), data[: found.start()] + data[end + len(_END) :]
        if b"raw" in found[1]:
            appended = path.read_bytes()[found.end() : end]
    root = ElementTree.fromstring(data)
    if root.tag != "VTKFile" or root.get("type") != "PolyData":
        raise MeshError(f"it holds {root.get('type', root.tag)[:30]!a} where PolyData is read; extract the surface")
    if root.get("compressor") not in (None, "vtkZLibDataCompressor"):
        raise MeshError(f"packed by {root.get('compressor', '')[:40]!a}, which is not read; write it by "
                        "vtkZLibDataCompressor")
    order = ">" if root.get("byte_order") == "BigEndian" else "<"
    header = np.dtype(f"{order}{_TYPES[root.get('header_type', 'UInt32')]}")
    file = XmlFile(order, header, root.get("compressor") is not None, appended,
                   found is not None and b"raw" not in found[1], stored)
    return _mesh(file, root)


def _mesh(file: XmlFile, root: ElementTree.Element) -> RawMesh:
    points = [np.empty((0, 3))]
    corners, ends = [np.empty(0, dtype=np.int64)], [np.empty(0, dtype=np.int64)]
    before = after = 0  # points and corners of the pieces before
    kept: list[dict[str, NDArray[Any]]] = []
    for piece in root.iter("Piece"):
        if int(piece.get("NumberOfStrips", "0")):
            raise MeshError("its triangle strips are not read; write triangles, as vtkTriangleFilter does")
        position = piece.find("Points/DataArray")
        if position is None or not int(piece.get("NumberOfPoints", "0")):
            continue
        points.append(file.array(position).reshape(-1, 3))
        own = {element.get("Name"): file.array(element) for element in piece.iterfind("Polys/DataArray")}
        if int(piece.get("NumberOfPolys", "0")):
            corners.append(own["connectivity"].astype(np.int64) + before)
            ends.append(own["offsets"].astype(np.int64) + after)
            after += len(corners[-1])
        before += len(points[-1])
        kept.append({element.get("Name", ""): file.array(element) for element in piece.iterfind("PointData/DataArray")
                     if element.get("type") in _TYPES})
    names = [name for name in (kept[0] if kept else {}) if all(name in each for each in kept)]
    data = {name: np.concatenate([each[name] for each in kept]) for name in names}
    return raw_mesh(np.concatenate(points), polygons(np.concatenate(corners), np.concatenate(ends)), data)


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write base64, the mark as a processing instruction, and the arrays of ``point_data`` that have a row a vertex."""
    kept = "".join(_array(name, values) for name, values in fitting(metadata, len(v)).items())
    ends = np.arange(3, 3 * len(f) + 1, 3)
    mark = f"<?mark {metadata['mark']}?>\n" if "mark" in metadata else ""
    text = (
        '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n'
        f'{mark}<PolyData>\n<Piece NumberOfPoints="{len(v)}" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" '
        f'NumberOfPolys="{len(f)}">\n<PointData>\n{kept}</PointData>\n<Points>\n{_array("Points", v)}</Points>\n'
        f'<Polys>\n{_array("connectivity", f.ravel())}{_array("offsets", ends)}</Polys>\n</Piece>\n</PolyData>\n'
        "</VTKFile>\n"
    )
    path.write_text(text, encoding="utf-8", newline="\n")


def _array(name: str, values: NDArray[Any]) -> str:
    """A DataArray element."""
    kind, width = values.dtype.str[1:], values.size // max(len(values), 1)
    data = values.astype(f"<{kind}").tobytes()
    block = base64.b64encode(len(data).to_bytes(8, "little") + data).decode("ascii")
    label = quoteattr(_NO_XML.sub("?", name))
    return (f'<DataArray type="{_NAMES[kind]}" Name={label} NumberOfComponents="{width}" format="binary">{block}'
            "</DataArray>\n")
