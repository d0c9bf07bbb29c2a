"""FreeSurfer's annotations (lh.aparc.annot): at each vertex the colour of its label, and a table of labels."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from ..errors import MeshError, printable
from ..mesh.arrays import IntArray
from .freesurfer import only
from .reading import Bytes
from .records import Label, LabelTable, Metadata, ScalarMaps

SUFFIX = ".annot"
# of tables whose entries have their places before them; older ones begin with their length
_VERSION = -2


def _text_of(file: Bytes) -> str:
    text = file.take(file.number(">i4")).split(b"\0")[0]
    return printable(text.decode("utf-8", errors="replace"))


def read_scalars(path: Path) -> dict[str, IntArray]:
    """The key of the label at each vertex, -1 for colours without a label, by the annotation's name."""
    colours, table = _read(path)
    codes = np.array([_code(label) for label in table], dtype=np.int64)
    keys = np.array([label.key for label in table] + [-1], dtype=np.int64)
    order = np.argsort(codes, kind="stable")  # of labels of one colour the first is taken
    place = np.append(order, len(codes))[np.searchsorted(codes, colours, sorter=order)]
    found = np.append(codes, -1)[place] == colours
    _, _, name = path.name.removesuffix(SUFFIX).partition(".")
    if not name:
        name = path.name
    return {name: np.where(found, keys[place], -1)}


def read_table(path: Path) -> LabelTable:
    """Read the table of labels, whose keys are their places in it."""
    return _read(path)[1]


def _read(path: Path) -> tuple[IntArray, LabelTable]:
    file = Bytes(path.read_bytes())
    n = file.number(">i4")
    rows = file.array(">i4", 2 * n).reshape(-1, 2).astype(np.int64)
    if not np.array_equal(np.sort(rows[:, 0]), np.arange(n)):
        raise MeshError("damaged: it does not name each vertex once; write the file anew")
    if file.at == len(file.data) or not file.number(">i4"):
        raise MeshError(
            "the annotation has no table of labels; write the file anew with its colours"
        )
    count = file.number(">i4")
    placed = count == _VERSION
    if placed:
        file.number(">i4")  # places, of which some may be empty
    _text_of(file)  # the name of the table's file
    if placed:
        count = file.number(">i4")
    table = []
    for k in range(count):
        key = k
        if placed:
            key = file.number(">i4")
        name = _text_of(file)
        red, green, blue, clear = file.array(">i4", 4).tolist()
        table.append(Label(key, name, (red / 255, green / 255, blue / 255, 1 - clear / 255)))
    return rows[np.argsort(rows[:, 0]), 1], tuple(table)


def write_scalars(path: Path, maps: ScalarMaps, metadata: Metadata) -> None:
    """Write one map of labels with the table that `metadata` has as ``labels``; keys become places in the table."""
    table = metadata.get("labels")
    if not table:
        raise MeshError(
            "an .annot file names labels, and the data have no table of them; write .label.gii or .npz"
        )
    name, values = only(maps)
    codes = {label.key: _code(label) for label in table}
    names: dict[int, str] = {}
    for label in table:
        other = names.setdefault(_code(label), label.name)
        if other is not label.name:
            raise MeshError(
                f"an .annot file distinguishes labels by their colours, and {other!r} and {label.name!r} "
                "have the same; write .label.gii or .npz"
            )
    keys, place = np.unique(values.astype(np.int64), return_inverse=True)
    unknown = set(keys.tolist()) - codes.keys() - {-1}
    if unknown:
        raise MeshError(
            f"{name} has the label {min(unknown)}, which its table lacks; write .label.gii or .npz"
        )
    colours = np.array([codes.get(key, 0) for key in keys.tolist()])[place]
    rows = np.stack([np.arange(len(colours)), colours], axis=1).astype(">i4")
    parts = [
        struct.pack(">i", len(rows)),
        rows.tobytes(),
        struct.pack(">3i", 1, _VERSION, len(table)),
        _text("NOFILE"),
        struct.pack(">i", len(table)),
    ]
    for k, label in enumerate(table):
        parts += [struct.pack(">i", k), _text(label.name), struct.pack(">4i", *_bytes(label))]
    path.write_bytes(b"".join(parts))


def _text(words: str) -> bytes:
    data = words.encode() + b"\0"
    return struct.pack(">i", len(data)) + data


def _bytes(label: Label) -> tuple[int, int, int, int]:
    """Red, green, blue, and transparency: FreeSurfer's 0 is opaque."""
    if not all(0 <= part <= 1 for part in label.rgba):
        raise MeshError(
            f"the colour of {label.name!r} is not from 0 to 1 but {label.rgba}; divide it by 255"
        )
    red, green, blue, alpha = (round(255 * part) for part in label.rgba)
    return red, green, blue, 255 - alpha


def _code(label: Label) -> int:
    """The number by which vertices have a colour."""
    red, green, blue, _ = _bytes(label)
    return red + (green << 8) + (blue << 16)
