"""Numbers in text files: read strictly, written so that they read back as they were."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import chain
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ..errors import MeshError
from .polygons import Polygons

Row = Sequence[bytes]
_BLOCK = 1 << 16  # rows formatted at once


def read_text(path: Path) -> bytes:
    """The bytes of a text file.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    bytes
        Its content.

    Raises
    ------
    MeshError
        If it holds binary data.
    """
    data = path.read_bytes()
    if b"\0" in data:
        raise MeshError(
            f"damaged: binary data where text is expected, at byte {data.index(0)}; "
            "check that the file is what its name says"
        )
    return data


def numbers(rows: Sequence[Row], width: int, what: str) -> NDArray[np.float64]:
    """The first `width` entries of each row as floats.

    Parameters
    ----------
    rows : sequence of sequences of bytes
        Tokens of each line.
    width : int
        How many of them are wanted.
    what : str
        What a row is, for messages.

    Returns
    -------
    (n, width) float64 array
        ``nan`` and ``inf`` are kept for the gate to name.

    Raises
    ------
    MeshError
        If a row is short or holds no number; it says which.
    """
    return _table(
        rows, width, float, np.float64, f"{what} {{}} reads {{!r}} where {width} numbers are expected"
    )


def indices(rows: Sequence[Row], what: str = "face") -> Polygons:
    """Rows of whole numbers as polygons, one row each.

    Parameters
    ----------
    rows : sequence of sequences of bytes
        Tokens of each line.
    what : str
        What a row is, for messages.

    Returns
    -------
    Polygons
        As the file counts, 0-based or 1-based.

    Raises
    ------
    MeshError
        If a row holds anything else; it says which.
    """
    message = f"{what} {{}} reads {{!r}} where whole numbers are expected"
    sizes = np.fromiter(map(len, rows), dtype=np.int64, count=len(rows))
    return Polygons(_flat(rows, int(sizes.sum()), int, np.int64, message), sizes)


def counted_indices(rows: Sequence[Row], lead: int = 0) -> Polygons:
    """Rows that state their number of indices first, as polygons; what comes after the indices is ignored.

    Parameters
    ----------
    rows : sequence of sequences of bytes
        Tokens of each line.
    lead : int
        How many tokens come before the number of indices.

    Returns
    -------
    Polygons
        The faces.

    Raises
    ------
    MeshError
        If a row is short or holds anything else; it says which.
    """
    size = _table(
        [row[lead:] for row in rows] if lead else rows,
        1,
        int,
        np.int64,
        "face {} reads {!r} where a number of corners is expected",
    ).ravel()
    start = lead + 1
    cut = [row[start : start + k] for row, k in zip(rows, size.tolist(), strict=True)]
    short = np.flatnonzero(size != np.fromiter(map(len, cut), dtype=np.int64, count=len(cut)))
    if len(short):
        raise _damaged("face {} reads {!r} where more corners are announced", int(short[0]), rows[short[0]])
    return indices(cut)


def write_rows(file: BinaryIO, template: str, rows: NDArray[Any]) -> None:
    """Write one line per row.

    Parameters
    ----------
    file : binary file
        Where to.
    template : str
        A line with one ``%r`` per column: the shortest decimals that read back as the same numbers.
    rows : (n, k) array
        The numbers.

    Returns
    -------
    None
    """
    for start in range(0, len(rows), _BLOCK):
        block = rows[start : start + _BLOCK]
        file.write(((template * len(block)) % tuple(block.ravel().tolist())).encode())


def _table(
    rows: Sequence[Row], width: int, kind: Callable[[bytes], Any], dtype: type, message: str
) -> NDArray[Any]:
    short = next((i for i, row in enumerate(rows) if len(row) < width), None)
    if short is not None:
        raise _damaged(message, short, rows[short])
    cut = [row[:width] for row in rows] if any(len(row) > width for row in rows) else rows
    return _flat(cut, width * len(rows), kind, dtype, message).reshape(-1, width)


def _flat(
    rows: Sequence[Row], count: int, kind: Callable[[bytes], Any], dtype: type, message: str
) -> NDArray[Any]:
    try:
        return np.fromiter(map(kind, chain.from_iterable(rows)), dtype=dtype, count=count)
    except (ValueError, OverflowError):
        raise _damaged(message, *_first_bad(rows, kind)) from None


def _first_bad(rows: Sequence[Row], kind: Callable[[bytes], Any]) -> tuple[int, Row]:
    """The first row with a token that is not of the kind, or a whole number beyond 64 bits."""
    for i, row in enumerate(rows):
        try:
            if kind is int and any(abs(int(token)) >= 2**63 for token in row):
                return i, row
            [kind(token) for token in row]
        except ValueError:
            return i, row
    return 0, rows[0]


def _damaged(message: str, i: int, row: Row) -> MeshError:
    text = b" ".join(row)[:40].decode("ascii", "replace")
    return MeshError(f"damaged: {message.format(i, text)}; correct the file or write it anew")
