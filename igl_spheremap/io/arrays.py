"""Plain arrays over vertices: .npy, tables of text (.csv, .tsv, .txt, AFNI's .1D), and MATLAB's .mat files."""

from __future__ import annotations

import csv
import io
import re
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.io import savemat

from ..errors import FileError, MeshError
from ..mesh.arrays import FloatArray
from .npz import array_of
from .reading import check_complete, expansion_limit
from .records import Metadata
from .tables import MARKED
from .text import write_text

_SEPARATED = (".csv", ".tsv")  # fields of other tables end at white space or commas
_SEPARATORS = "\t;,"
_QUOTED = re.compile('"[^"]*"')
#: Bytes of the head of a MAT-file of version 5, and of the text that it begins with, before version and byte order;
#: elements follow, each with a type and a size. Names of arrays have no more letters than `_NAME`.
_HEAD, _TEXT, _NAME = 128, 116, 31
_ORDERS = {b"\x00\x01IM": "<", b"\x01\x00MI": ">"}
#: Types of elements, of the classes of matrices those of numbers, and the flag of those with an imaginary part.
_COMPRESSED, _MATRIX = 15, 14
_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_NUMERIC = range(6, 16)
_COMPLEX = 1 << 11


def _by_place(table: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """Name the columns of an array by their places; take a single row for a column."""
    columns = table.reshape(-1, 1) if table.ndim < 2 or len(table) == 1 else table
    if table.ndim > 2 or columns.shape[1] > len(columns):
        raise MeshError(f"it holds an array of {' x '.join(map(str, table.shape))}; give one row a vertex")
    return {str(k): column for k, column in enumerate(columns.T)}


def read_npy(path: Path) -> dict[str, NDArray[Any]]:
    """The columns of an array."""
    return _by_place(array_of(path.read_bytes()))


def write_npy(path: Path, maps: dict[str, FloatArray], metadata: Metadata) -> None:
    """Write one map as (n,), several as columns."""
    columns = _columns(maps, metadata)
    with path.open("wb") as file:
        np.save(file, columns[:, 0] if len(maps) == 1 else columns)


def _columns(maps: dict[str, FloatArray], metadata: Metadata) -> NDArray[Any]:
    """Maps side by side; labels as whole numbers."""
    return np.stack(list(maps.values()), axis=1).astype(np.int64 if "labels" in metadata else np.float64)


def read_table(path: Path) -> dict[str, NDArray[Any]]:
    """The columns of a table by its header, or else by their places; columns that begin with a text are left out."""
    lines = [(number, line) for number, line in enumerate(path.read_bytes().decode("utf-8-sig").splitlines(), 1)
             if line.strip() and not line.lstrip().startswith("#")]
    if not lines:
        raise MeshError("it holds no numbers; give one row a vertex")
    text = [line for _, line in lines]
    if path.suffix.lower() in _SEPARATED:
        unquoted = _QUOTED.sub("", text[0])
        rows = list(csv.reader(text, delimiter=next((mark for mark in _SEPARATORS if mark in unquoted), ",")))
    else:
        rows = [re.split(r"\s*,\s*|\s+", line.strip()) for line in text]
    for (number, _), row in zip(lines, rows, strict=True):
        if len(row) != len(rows[0]):
            raise MeshError(f"line {number} has {len(row)} fields where line {lines[0][0]} has {len(rows[0])}; correct "
                            "the table")
    if len(rows[0]) > len(rows) > 1:
        raise MeshError(f"it holds {len(rows)} lines of {len(rows[0])} fields; give one line a vertex")
    headed = not any(map(_is_number, rows[0]))
    names = [(headed and _name_of(name.strip())) or str(k) for k, name in enumerate(rows[0])]
    if len(set(names)) < len(names):
        raise MeshError(f"two columns are called {max(names, key=names.count)!a}; rename one")
    body = rows[headed:]
    columns = {}
    for k, name in enumerate(names):
        fields = [row[k] for row in body]
        bad = next((i for i, field in enumerate(fields) if not _is_number(field)), -1)
        if bad > 0 or (bad == 0 and len(names) == 1):
            raise MeshError(f"line {lines[headed + bad][0]} reads {fields[bad][:40]!a} in column {name[:40]!a} where a "
                            "number is expected; correct the table")
        if bad < 0 and fields:
            columns[name] = np.fromiter(map(float, fields), dtype=np.float64, count=len(fields))
    return columns if headed or len(body) > 1 else _by_place(np.concatenate([np.empty(0), *columns.values()]))


def _is_number(field: str) -> bool:
    try:
        float(field)
    except ValueError:
        return False
    return "_" not in field  # Python takes it for a mark between digits


def _is_marked(name: str) -> bool:
    """Whether a name has an apostrophe before it in a header: without it, it would be a formula, a comment or a number.

    Spreadsheets take such a cell for a text, too.
    """
    return name.startswith((*MARKED, "#")) or _is_number(name)


def _name_of(cell: str) -> str:
    return cell[1:] if cell.startswith("'") and _is_marked(cell[1:]) else cell


def _cell_of(name: str) -> str:
    marked = f"'{name}" if _is_marked(name) else name
    return '"{}"'.format(marked.replace('"', '""')) if set(marked) & {*_SEPARATORS, '"'} else marked


def write_table(path: Path, maps: dict[str, FloatArray], metadata: Metadata) -> None:
    """Write a line a vertex with the digits that read back; .csv and .tsv with the names as their header."""
    mark = "," if path.suffix.lower() == ".csv" else "\t"
    head = mark.join(map(_cell_of, maps)) + "\n" if path.suffix.lower() in _SEPARATED else ""
    write_text(path, head, {}, (mark.join(["%r"] * len(maps)) + "\n", _columns(maps, metadata)))


def read_mat(path: Path) -> dict[str, NDArray[Any]]:
    """The vectors of real numbers of a MAT-file of version 5, 6 or 7; scipy's reader crashes on damaged ones."""
    data = path.read_bytes()
    order = _ORDERS.get(data[_HEAD - 4 : _HEAD])
    if order is None:
        raise MeshError("not a MAT-file of version 5 to 7; save it by save(..., '-v7')")
    found, left = {}, expansion_limit(len(data))
    for kind, content in _elements(data[_HEAD:], order):
        if kind == _COMPRESSED:
            content = zlib.decompressobj().decompress(content, left + 1)
            left -= len(content)
            if left < 0:
                raise MeshError(f"its {len(data)} bytes expand to far more than data over vertices; write it anew")
            kind, content = next(_elements(content, order))
        if kind != _MATRIX:
            continue
        parts = _elements(content, order)
        flags = int(np.frombuffer(next(parts)[1], f"{order}u4")[0])
        shape = np.frombuffer(next(parts)[1], f"{order}i4")
        name = next(parts)[1].decode("latin-1")
        if flags & 255 not in _NUMERIC or flags & _COMPLEX or len(shape) != 2 or shape.min() != 1 or shape.max() < 2:
            continue
        kind, content = next(parts)
        values = np.frombuffer(content, f"{order}{_TYPES[kind]}")
        check_complete(len(values) == shape.max(), f"{len(values)} numbers", f"{shape.max()}")
        found[name] = values
    return found


def _elements(data: bytes, order: str) -> Iterator[tuple[int, bytes]]:
    """Yield type and content of each element of a MAT-file; short contents lie within the eight bytes of the tag."""
    at = 0
    while at < len(data):
        check_complete(at + 8 <= len(data), f"{len(data) - at} bytes", "8")
        kind, size = struct.unpack(f"{order}II", data[at : at + 8])
        begin = at + 8
        if kind >> 16:
            begin, kind, size = at + 4, kind & 0xFFFF, kind >> 16
        check_complete(begin + size <= len(data), f"{len(data) - begin} bytes", f"{size}")
        yield kind, data[begin : begin + size]
        at = begin + size if kind == _COMPRESSED else begin + size + -(begin + size) % 8


def write_mat(path: Path, maps: dict[str, FloatArray], metadata: Metadata) -> None:
    """Write columns by their names, as MATLAB allows them; the head without scipy's date, to be the same each time."""
    names = [re.sub(r"\W", "_", re.sub("^(?![A-Za-z])", "x", name), flags=re.ASCII)[:_NAME] for name in maps]
    if len(set(names)) < len(names):
        raise FileError(f"{path}: two of {', '.join(maps)} would have one name in MATLAB; rename one, or write "
                        "another format")
    file = io.BytesIO()
    savemat(file, dict(zip(names, _columns(maps, metadata).T, strict=True)), oned_as="column")
    data = file.getvalue()
    path.write_bytes(b"MATLAB 5.0 MAT-file, igl_spheremap".ljust(_TEXT) + data[_TEXT:])
