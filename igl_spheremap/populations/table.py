"""The table of a population: one row an input, as TSV, CSV or JSON lines."""

from __future__ import annotations

import csv
import io
import json
import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import MISSING, asdict, dataclass, fields
from pathlib import Path
from typing import Any

from ..errors import FileError
from ..io.reading import reading
from ..io.replacing import replacing

_SEPARATORS = {".tsv": "\t", ".csv": ","}
#: Suffixes of tables.
FORMATS = (*_SEPARATORS, ".jsonl")
_CONVERT: dict[str, Callable[[Any], Any]] = {
    "bool": lambda value: str(value).lower() == "true", "int": int, "str": str,
    "float": lambda value: math.nan if value in (None, "") else float(value),
}  # fmt: skip
#: First characters that make a spreadsheet take a cell for a formula, and the quote that is put before them.
_QUOTED = ("=", "+", "-", "@", "\t", "\r", "'")
#: Statuses of rows whose target holds a map.
MAPPED = ("certified", "folded")


@dataclass(frozen=True, slots=True)
class Row:
    """What is known of one input and its map; figures are NaN where there is no map.

    Attributes
    ----------
    source, target : str
        The mesh file and the file of its sphere, as they were given.
    status : str
        "certified"; "folded", if foldings remain; "no mesh", if the input is no closed genus-0 mesh; "file", if a file
        can't be read or written; "failed", if the computation failed or passed a limit, or its worker died.
    resumed : bool
        Whether an earlier run made it.
    vertices : int
        Of the mesh.
    foldings_before, foldings : int
        Folded faces before the repair, and in the file.
    energy : float
        Harmonic energy, eq. (6).
    mean_angle, p99_angle, max_angle : float
        Mean, 99th percentile and maximum of the sizes of angle differences, in degrees.
    mean_area, p99_area, max_area : float
        The same of the logarithms of image area over source area, each surface having area 1.
    mean_edge, p99_edge, max_edge : float
        The same of the logarithms of image length over source length.
    stretch : float
        Limbs too deep for float64 are mapped as if up to so many times shorter; 1 if there is none.
    seconds : float
        Wall time of reading, mapping and writing.
    memory : float
        Peak memory of the worker's process during the job, in MB.
    worker : str
        Host and process.
    notes : str
        What was done beyond the ordinary, or why there is no map.
    """

    source: str
    target: str
    status: str = "certified"
    resumed: bool = False
    vertices: int = 0
    foldings_before: int = 0
    foldings: int = 0
    energy: float = math.nan
    mean_angle: float = math.nan
    p99_angle: float = math.nan
    max_angle: float = math.nan
    mean_area: float = math.nan
    p99_area: float = math.nan
    max_area: float = math.nan
    mean_edge: float = math.nan
    p99_edge: float = math.nan
    max_edge: float = math.nan
    stretch: float = math.nan
    seconds: float = 0.0
    memory: float = math.nan
    worker: str = ""
    notes: str = ""


def plain(row: Row) -> dict[str, Any]:
    """A row for JSON: what is not finite is None.

    >>> plain(Row("a.ply", "b.ply", status="no mesh"))["energy"] is None
    True
    """
    return {key: None if isinstance(value, float) and not math.isfinite(value) else value
            for key, value in asdict(row).items()}


def from_plain(entry: Mapping[str, Any]) -> Row:
    """The row that `plain` or a line of a table describes; TypeError and ValueError where it is none."""
    values = {}
    for field in fields(Row):
        text = entry[field.name] if field.default is MISSING else entry.get(field.name, field.default)
        values[field.name] = _CONVERT[str(field.type)](text)
    return Row(**values)


def check_table(path: str | os.PathLike[str]) -> None:
    """Raise a ValueError unless the name is one of a table."""
    if not str(path).lower().endswith(FORMATS):
        raise ValueError(f"{path}: give a {', '.join(FORMATS[:-1])} or {FORMATS[-1]} file")


def write_table(path: str | os.PathLike[str], rows: Sequence[Row]) -> None:
    """Write a table; what is not finite is left empty, or null."""
    with replacing(path, force=True) as partial:
        partial.write_text(_text(rows, Path(path).suffix.lower()), encoding="utf-8", errors="backslashreplace")


def _text(rows: Sequence[Row], suffix: str) -> str:
    entries = [plain(row) for row in rows]
    if suffix not in _SEPARATORS:
        return "".join(json.dumps(entry) + "\n" for entry in entries)
    text = io.StringIO()
    names = [field.name for field in fields(Row)]
    writer = csv.DictWriter(text, names, lineterminator="\n", delimiter=_SEPARATORS[suffix])
    writer.writeheader()
    writer.writerows({key: _cell(value) for key, value in entry.items()} for entry in entries)
    return text.getvalue()


def _cell(value: object) -> object:
    """A cell that no spreadsheet takes for a formula."""
    return f"'{value}" if isinstance(value, str) and value.startswith(_QUOTED) else value


def read_table(path: str | os.PathLike[str]) -> list[Row]:
    """The rows of a table, or those that a manifest holds so far: the last one of each target."""
    path = Path(path)
    with reading(path):
        rows = {row.target: row for row in _rows(path)}
    if not rows:
        raise FileError(f"{path} has no row; give a table or a manifest of igl-spheremap batch")
    return list(rows.values())


def _rows(path: Path) -> Iterator[Row]:
    suffix = path.suffix.lower()
    with path.open(encoding="utf-8", newline="") as file:
        if suffix in _SEPARATORS:
            for entry in csv.DictReader(file, delimiter=_SEPARATORS[suffix]):
                yield from_plain({key: _unquoted(text) for key, text in entry.items()})
            return
        for entry in json_lines(file):
            if "source" in (entry := entry.get("row", entry)):
                yield from_plain(entry)


def _unquoted(text: str) -> str:
    return text[1:] if text.startswith("'") and text[1:].startswith(_QUOTED) else text


def json_lines(file: io.TextIOBase | io.TextIOWrapper) -> Iterator[dict[str, Any]]:
    """The objects of a file of JSON lines; a line that was cut off is left out."""
    for line in file:
        try:
            entry = json.loads(line)
        except ValueError:
            continue
        if isinstance(entry, dict):
            yield entry
