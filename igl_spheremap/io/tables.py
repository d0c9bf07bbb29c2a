"""Tables for people and spreadsheets, .tsv and .csv, whose cells no program takes for formulas."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from ..gate import PathLike
from .replacing import replacing

#: Separators of cells, by the suffix.
SEPARATORS = {".tsv": "\t", ".csv": ","}
#: First characters that make a spreadsheet take a cell for a formula, and the quote that is put before them.
MARKED = ("=", "+", "-", "@", "\t", "\r", "'")


def write_cells(path: PathLike, rows: Iterable[Sequence[object]], *, force: bool = False) -> None:
    """Write rows of cells, the header first; the suffix decides the separator."""
    with replacing(path, force) as partial:
        partial.write_text(
            text_of(rows, Path(path).suffix.lower()), encoding="utf-8", errors="backslashreplace"
        )


def text_of(rows: Iterable[Sequence[object]], suffix: str) -> str:
    """The text of a table.

    >>> text_of([("name", "size"), ("=1+1", -1.5)], ".csv")
    "name,size\\n'=1+1,-1.5\\n"
    """
    text = io.StringIO()
    csv.writer(text, delimiter=SEPARATORS[suffix], lineterminator="\n").writerows(map(_cells, rows))
    return text.getvalue()


def read_cells(path: Path) -> list[list[str]]:
    """The rows of a table, the header first, as `write_cells` was given them; empty lines are left out."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        return [
            [_unquoted(cell) for cell in row]
            for row in csv.reader(file, delimiter=SEPARATORS[path.suffix.lower()])
            if row
        ]


def _cells(row: Sequence[object]) -> Iterator[object]:
    for cell in row:
        if isinstance(cell, str) and cell.startswith(MARKED):
            yield f"'{cell}"
        else:
            yield cell


def _unquoted(text: str) -> str:
    if text.startswith("'") and text[1:].startswith(MARKED):
        return text[1:]
    return text
