"""FreeSurfer's annotations (lh.aparc.annot): at each vertex the colour of its label, and a table of labels."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from ..errors import MeshError, printable
from ..mesh.arrays import FloatArray, IntArray
from .freesurfer import only
from .reading import check_complete
from .records import Label, Metadata

SUFFIX = ".annot"
_VERSION = -2  # where each entry of the table has its place before it; older tables begin with their length


class _Numbers:
    """Read big-endian numbers and texts one after another, and refuse a file that ends too early."""

    def __init__(self, data: bytes) -> None:
        self._data, self._at = data, 0

    def take(self, size: int) -> bytes:
        left = len(self._data) - self._at
        check_complete(0 <= size <= left, f"{left} bytes", str(size))
        self._at += size
        return self._data[self._at - size : self._at]

    def next(self) -> int:
        return int(struct.unpack(">i", self.take(4))[0])

    def text(self) -> str:
        return printable(self.take(self.next()).split(b"\0")[0].decode("utf-8", errors="replace"))

    @property
    def ended(self) -> bool:
        return self._at == len(self._data)


def read_scalars(path: Path) -> dict[str, IntArray]:
    """The key of the label at each vertex, -1 where the colour is that of none, by the annotation's name."""
    colours, table = _read(path)
    codes = np.array([_code(label) for label in table], dtype=np.int64)
    keys = np.array([label.key for label in table] + [-1], dtype=np.int64)
    order = np.argsort(codes, kind="stable")  # of labels of one colour the first is taken
    place = np.append(order, len(codes))[np.searchsorted(codes, colours, sorter=order)]
    found = np.append(codes, -1)[place] == colours
    return {path.name.removesuffix(SUFFIX).partition(".")[2] or path.name: np.where(found, keys[place], -1)}


def read_table(path: Path) -> tuple[Label, ...]:
    """Read the table of labels, whose keys are their places in it."""
    return _read(path)[1]


def _read(path: Path) -> tuple[IntArray, tuple[Label, ...]]:
    numbers = _Numbers(path.read_bytes())
    n = numbers.next()
    rows = np.frombuffer(numbers.take(8 * n), ">i4").reshape(-1, 2).astype(np.int64)
    if not np.array_equal(np.sort(rows[:, 0]), np.arange(n)):
        raise MeshError("damaged: it does not name each vertex once; write the file anew")
    if numbers.ended or not numbers.next():
        raise MeshError("the annotation has no table of labels; write the file anew with its colours")
    count = numbers.next()
    placed = count == _VERSION
    if placed:
        numbers.next()  # places, of which some may be empty
    numbers.text()  # the name of the table's file
    table = []
    for k in range(numbers.next() if placed else count):
        key, name = numbers.next() if placed else k, numbers.text()
        red, green, blue, clear = struct.unpack(">4i", numbers.take(16))
        table.append(Label(key, name, (red / 255, green / 255, blue / 255, 1 - clear / 255)))
    return rows[np.argsort(rows[:, 0]), 1], tuple(table)


def write_scalars(path: Path, maps: dict[str, FloatArray], metadata: Metadata) -> None:
    """Write one map of labels with the table that `metadata` has as ``labels``; keys become places in the table."""
    table = metadata.get("labels")
    if not table:
        raise MeshError("an .annot file names labels, and the data have no table of them; write .label.gii or .npz")
    name, values = only(maps)
    codes = {label.key: _code(label) for label in table}
    names: dict[int, str] = {}
    for label in table:
        other = names.setdefault(_code(label), label.name)
        if other is not label.name:
            raise MeshError(f"an .annot file distinguishes labels by their colours, and {other!r} and {label.name!r} "
                            "have the same; write .label.gii or .npz")
    keys, place = np.unique(values.astype(np.int64), return_inverse=True)
    unknown = set(keys.tolist()) - codes.keys() - {-1}
    if unknown:
        raise MeshError(f"{name} has the label {min(unknown)}, which its table lacks; write .label.gii or .npz")
    colours = np.array([codes.get(key, 0) for key in keys.tolist()])[place]
    rows = np.stack([np.arange(len(colours)), colours], axis=1).astype(">i4")
    parts = [struct.pack(">i", len(rows)), rows.tobytes(), struct.pack(">3i", 1, _VERSION, len(table)), _text("NOFILE"),
             struct.pack(">i", len(table))]
    for k, label in enumerate(table):
        parts += [struct.pack(">i", k), _text(label.name), struct.pack(">4i", *_bytes(label))]
    path.write_bytes(b"".join(parts))


def _text(words: str) -> bytes:
    data = words.encode() + b"\0"
    return struct.pack(">i", len(data)) + data


def _bytes(label: Label) -> tuple[int, int, int, int]:
    """Red, green, blue, and transparency: FreeSurfer's 0 is opaque."""
    if not all(0 <= part <= 1 for part in label.rgba):
        raise MeshError(f"the colour of {label.name!r} is not from 0 to 1 but {label.rgba}; divide it by 255")
    red, green, blue, alpha = (round(255 * part) for part in label.rgba)
    return red, green, blue, 255 - alpha


def _code(label: Label) -> int:
    """The number by which vertices have a colour."""
    red, green, blue, _ = _bytes(label)
    return red + (green << 8) + (blue << 16)
