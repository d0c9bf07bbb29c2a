"""Text files of numbers: read strictly, written so that they read back unchanged.

A file of a million lines is read without an object for each line. Lines are offsets, numpy counts their tokens, and
only wanted tokens become numbers.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import MeshError
from ..mesh.arrays import AnyArray, BoolArray, FloatArray, IntArray, PixelArray
from .records import Metadata, Polygons


@dataclass(frozen=True, eq=False)
class TextRows:
    """Lines that are not empty, with their tokens counted."""

    text: PixelArray  # all of it; each line ends with a newline
    begin: IntArray  # where the first token of each line starts
    end: IntArray  # where the newline of each line is
    counts: IntArray  # tokens of each line

    def __len__(self) -> int:
        return len(self.counts)

    def __getitem__(self, which: slice | BoolArray) -> TextRows:
        return TextRows(self.text, self.begin[which], self.end[which], self.counts[which])

    def starting_with(self, word: bytes) -> TextRows:
        """The lines whose first token is a word, without it."""
        found = self.counts > 0
        for k, letter in enumerate(word):
            found &= self.text[np.minimum(self.begin + k, self.end)] == letter
        found &= self.text[np.minimum(self.begin + len(word), self.end)] <= ord(" ")
        rows = self[found]
        return TextRows(self.text, rows.begin + len(word), rows.end, rows.counts - 1)

    def bytes(self) -> bytes:
        """The lines' text."""
        if len(self) == 0:
            return b""
        step = np.zeros(len(self.text) + 1, dtype=np.int8)
        step[self.begin] += 1
        step[self.end + 1] -= 1
        return self.text[np.cumsum(step[:-1], dtype=np.int8).astype(bool)].tobytes()

    def line(self, i: int) -> str:
        """The start of one line, for messages."""
        text = bytes(self.text[self.begin[i] : self.end[i]])
        return b" ".join(text.split())[:40].decode("ascii", "replace")


def read_rows(data: bytes) -> TextRows:
    """Split text into the lines that are not empty; a ``#`` begins a comment.

    Examples
    --------
    >>> rows = read_rows(b"v 1 2 3 # a vertex\\n\\nf 1 2 3")
    >>> rows.counts.tolist(), rows.starting_with(b"f").bytes()
    ([4, 4], b' 1 2 3\\n')
    """
    if b"\0" in data:
        raise MeshError(
            f"damaged: binary data where text is expected, at byte {data.index(0)}; "
            "check that the file is what its name says"
        )
    if b"#" in data:
        data = re.sub(rb"#[^\r\n]*", b"", data)
    text = np.frombuffer(data.replace(b"\r", b"\n") + b"\n", dtype=np.uint8)
    blank = text <= ord(" ")
    tokens = np.flatnonzero(~blank & np.append(True, blank[:-1]))
    end = np.flatnonzero(text == ord("\n"))
    upto = np.searchsorted(tokens, end)
    counts = np.diff(upto, prepend=0)
    full = counts > 0
    return TextRows(text, tokens[(upto - counts)[full]], end[full], counts[full])


def numbers(rows: TextRows, width: int, what: str) -> FloatArray:
    """The first `width` tokens of each line as floats; `what` names a line in messages."""
    message = f"{what} {{}} reads {{!r}} where {width} numbers are expected"
    _refuse(rows.counts < width, message, rows)
    return _convert(rows, _first(rows.counts)[:, None] + np.arange(width), float, message)


def indices(rows: TextRows) -> Polygons:
    """Lines of vertex indices as polygons, indices as in the file; a ``/`` in a token and all behind it are left
    out."""
    message = "face {} reads {!r} where whole numbers are expected"
    return Polygons(_convert(rows, np.arange(rows.counts.sum()), int, message), rows.counts)


def counted_indices(rows: TextRows, lead: int = 0) -> Polygons:
    """Lines that state their number of indices, behind `lead` other tokens, as polygons; the rest is left out."""
    message = "face {} reads {!r} where a number of corners and as many whole numbers are expected"
    _refuse(rows.counts <= lead, message, rows)
    head = _first(rows.counts) + lead
    sizes = _convert(rows, head, int, message)
    _refuse((sizes < 0) | (sizes > rows.counts - lead - 1), message, rows)
    before: IntArray = np.repeat(head + 1 - _first(sizes), sizes)
    return Polygons(_convert(rows, before + np.arange(len(before)), int, message), sizes)


def _first(counts: IntArray) -> IntArray:
    """The number of the first of each group of tokens, the groups behind one another."""
    return np.cumsum(counts) - counts


def write_text(
    path: Path,
    head: str,
    metadata: Metadata,
    *parts: tuple[str, AnyArray],
    at_once: int = 1 << 16,
) -> None:
    """Write a head, the mark as a comment, and for each template and array one line a row, in blocks of lines.

    A template has a ``%r`` for each column: the shortest digits that read back.
    """
    with path.open("wb") as file:
        file.write(head.encode())
        if "mark" in metadata:
            file.write(f"# {metadata['mark']}\n".encode())
        for template, rows in parts:
            for start in range(0, len(rows), at_once):
                block = rows[start : start + at_once]
                file.write(((template * len(block)) % tuple(block.ravel().tolist())).encode())


def _convert(rows: TextRows, places: IntArray, kind: type[int | float], message: str) -> AnyArray:
    """Convert the tokens at some places among those of all lines to numbers, in an array of the shape of `places`."""
    text = rows.bytes()
    if kind is int and b"/" in text:
        text = re.sub(rb"/\S*", b"", text)
    tokens = text.split()
    if places.size < len(tokens):
        tokens = [tokens[k] for k in places.ravel().tolist()]
    try:
        if b"_" in text:  # Python takes it for a mark between digits
            raise ValueError
        found = np.fromiter(map(kind, tokens), {int: "i8", float: "f8"}[kind], len(tokens))
        return found.reshape(places.shape)
    except (ValueError, OverflowError):
        bad = next(k for k, token in enumerate(tokens) if not _is(kind, token))
        _refuse(np.cumsum(rows.counts) > places.ravel()[bad], message, rows)
        raise


def _is(kind: type[int | float], token: bytes) -> bool:
    """Whether a token is a number of that kind, and a whole one within 64 bits."""
    try:
        return b"_" not in token and (abs(kind(token)) < 2**63 or kind is float)
    except ValueError:
        return False


def _refuse(wrong: BoolArray, message: str, rows: TextRows) -> None:
    """A MeshError on the first wrong line, if any."""
    if wrong.any():
        i = int(wrong.argmax())
        raise MeshError(
            f"damaged: {message.format(i, rows.line(i))}; correct the file or write it anew"
        )
