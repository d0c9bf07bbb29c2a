"""The header of a PLY file."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from ..errors import MeshError

_TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "float": "f4",
    "double": "f8",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "int64": "i8",
    "uint64": "u8",
    "float32": "f4",
    "float64": "f8",
}


@dataclass(frozen=True)
class Property:
    """A scalar, or a list where `count` is the type of its length."""

    name: str
    type: np.dtype
    count: np.dtype | None = None


@dataclass(frozen=True)
class Element:
    """A kind of rows: vertices, faces, ..."""

    name: str
    size: int
    properties: tuple[Property, ...]


@dataclass(frozen=True)
class Header:
    """What a PLY file announces.

    Attributes
    ----------
    ascii : bool
        Whether the body is text.
    elements : tuple of Element
        In the order of the body.
    end : int
        Where the body starts, in bytes.
    """

    ascii: bool
    elements: tuple[Element, ...]
    end: int


def parse_header(data: bytes) -> Header:
    """Parse the header of a PLY file.

    Parameters
    ----------
    data : bytes
        The whole file.

    Returns
    -------
    Header
        What it announces.

    Raises
    ------
    MeshError
        If it is none.

    Examples
    --------
    >>> header = parse_header(b"ply\\nformat ascii 1.0\\nelement vertex 3\\nproperty float x\\nend_header\\n")
    >>> header.elements[0].size
    3
    """
    end = re.search(rb"^end_header[ \t]*\r?\n", data[: 1 << 20], re.MULTILINE)
    if not data.startswith(b"ply") or end is None:
        raise MeshError("damaged: no PLY header; check that the file is what its name says")
    encoding, order, elements = "", "<", list[tuple[str, int, list[Property]]]()
    for line in data[: end.start()].decode("ascii", "replace").splitlines()[1:]:
        words = line.split()
        try:
            if words[:1] == ["format"]:
                encoding, order = words[1], ">" if words[1] == "binary_big_endian" else "<"
            elif words[:1] == ["element"]:
                elements.append((words[1], int(words[2]), []))
            elif words[:1] == ["property"]:
                elements[-1][2].append(_property(words[1:], order))
        except (IndexError, KeyError, ValueError):
            raise MeshError(
                f"damaged: PLY header line {line[:60]!r} makes no sense; write the file anew"
            ) from None
    if encoding not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise MeshError(f"damaged: unknown PLY encoding {encoding!r}; write the file anew")
    return Header(encoding == "ascii", tuple(Element(n, k, tuple(p)) for n, k, p in elements), end.end())


def _property(words: list[str], order: str) -> Property:
    if words[0] == "list":
        return Property(words[3], np.dtype(order + _TYPES[words[2]]), np.dtype(order + _TYPES[words[1]]))
    return Property(words[1], np.dtype(order + _TYPES[words[0]]))
