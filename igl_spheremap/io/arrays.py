"""Plain arrays over vertices: .npy, and tables of text (.csv, .tsv, .txt, AFNI's .1D)."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np

from ..errors import MeshError
from ..mesh.arrays import AnyArray
from .npz import array_of
from .records import Metadata, NamedArrays, ScalarMaps
from .tables import MARKED, SEPARATORS
from .text import write_text

_ARRAY = ".npy"
_SEPARATORS = "\t;,"


def _by_place(table: AnyArray) -> NamedArrays:
    """Name the columns of an array by their places; take a single row for a column."""
    columns = table
    if table.ndim < 2 or len(table) == 1:
        columns = table.reshape(-1, 1)
    if table.ndim > 2 or columns.shape[1] > len(columns):
        raise MeshError(
            f"it holds an array of {' x '.join(map(str, table.shape))}; give one row a vertex"
        )
    return {str(k): column for k, column in enumerate(columns.T)}


def read_scalars(path: Path) -> NamedArrays:
    """The columns of an array, or of a table."""
    if path.suffix.lower() == _ARRAY:
        return _by_place(array_of(path.read_bytes()))
    return _read_table(path)


def write_scalars(path: Path, maps: ScalarMaps, metadata: Metadata) -> None:
    """Write maps as columns, labels as whole numbers; names go to .csv and .tsv, one map to an .npy file as (n,)."""
    columns = np.stack(list(maps.values()), axis=1).astype(np.float64)
    if "labels" in metadata:
        columns = columns.astype(np.int64)
    suffix = path.suffix.lower()
    if suffix == _ARRAY:
        if len(maps) == 1:
            columns = columns[:, 0]
        with path.open("wb") as file:
            np.save(file, columns)
        return
    mark, head = SEPARATORS.get(suffix, "\t"), ""
    if suffix in SEPARATORS:
        head = mark.join(map(_cell_of, maps)) + "\n"
    write_text(path, head, {}, (mark.join(["%r"] * len(maps)) + "\n", columns))


def _read_table(path: Path) -> NamedArrays:
    """The columns of a table by its header, or else by their places, without columns that begin with a text."""
    lines = [
        (number, line)
        for number, line in enumerate(path.read_bytes().decode("utf-8-sig").splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not lines:
        raise MeshError("it holds no numbers; give one row a vertex")
    text = [line for _, line in lines]
    if path.suffix.lower() in SEPARATORS:
        unquoted = re.sub('"[^"]*"', "", text[0])
        mark = next((mark for mark in _SEPARATORS if mark in unquoted), ",")
        rows = list(csv.reader(text, delimiter=mark))
    else:
        rows = [re.split(r"\s*,\s*|\s+", line.strip()) for line in text]
    for (number, _), row in zip(lines, rows, strict=True):
        if len(row) != len(rows[0]):
            raise MeshError(
                f"line {number} has {len(row)} fields where line {lines[0][0]} has {len(rows[0])}; correct "
                "the table"
            )
    if len(rows[0]) > len(rows) > 1:
        raise MeshError(
            f"it holds {len(rows)} lines of {len(rows[0])} fields; give one line a vertex"
        )
    headed = not any(map(_is_number, rows[0]))
    names, body = [str(k) for k in range(len(rows[0]))], rows
    if headed:
        body = rows[1:]
        for k, cell in enumerate(rows[0]):
            if name := _name_of(cell.strip()):
                names[k] = name
    if len(set(names)) < len(names):
        raise MeshError(f"two columns are called {max(names, key=names.count)!a}; rename one")
    columns = {}
    for k, name in enumerate(names):
        fields = [row[k] for row in body]
        bad = next((i for i, field in enumerate(fields) if not _is_number(field)), -1)
        if bad > 0 or (bad == 0 and len(names) == 1):
            raise MeshError(
                f"line {lines[bad - len(body)][0]} reads {fields[bad][:40]!a} in column {name[:40]!a} where a "
                "number is expected; correct the table"
            )
        if bad < 0 and fields:
            columns[name] = np.fromiter(map(float, fields), dtype=np.float64, count=len(fields))
    if headed or len(body) > 1:
        return columns
    return _by_place(np.concatenate([np.empty(0), *columns.values()]))


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
    if cell.startswith("'") and _is_marked(cell[1:]):
        return cell[1:]
    return cell


def _cell_of(name: str) -> str:
    if _is_marked(name):
        name = f"'{name}"
    if set(name) & {*_SEPARATORS, '"'}:
        return '"{}"'.format(name.replace('"', '""'))
    return name
