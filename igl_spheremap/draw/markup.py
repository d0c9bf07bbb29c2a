"""HTML for notebooks and reports: tables, pictures, and surfaces that the reader can turn (WebGL, no download)."""

from __future__ import annotations

import base64
import io
import json
import struct
import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._version import __version__
from ..errors import import_optional
from ..mesh.arrays import FloatArray, IntArray
from .folds import ABOVE, NEARER, SEEN, Marks
from .palette import FOLDED, Colour, Ramp


def table(rows: Iterable[Sequence[str]], header: Sequence[str] = ()) -> str:
    """A table of texts, which are escaped; without a header the first cell of each row is its label.

    >>> table([("a", "x < y")])
    '<table><tr><th scope="row">a</th><td>x &lt; y</td></tr></table>'
    """
    head = "".join(f'<th scope="col">{escape(cell)}</th>' for cell in header)
    lines = []
    if header:
        lines.append(f"<tr>{head}</tr>")
    for row in rows:
        cells = [f"<td>{escape(cell)}</td>" for cell in row]
        if not header:
            cells[0] = f'<th scope="row">{escape(row[0])}</th>'
        lines.append(f"<tr>{''.join(cells)}</tr>")
    return f"<table>{''.join(lines)}</table>"


def picture(png: bytes, caption: str) -> str:
    """A PNG as part of the page, with a caption."""
    text = escape(caption)
    return f'<figure><img alt="{text}" src="{data_address(png)}"><figcaption>{text}</figcaption></figure>'


def png(image: NDArray[np.uint8]) -> bytes:
    """The PNG file of an image (height, width, 3), rows from above, each pixel as the difference from that to its left.

    >>> png(np.zeros((1, 1, 3), np.uint8))[:4]
    b'\\x89PNG'
    """
    height, width = image.shape[:2]
    steps = np.diff(image, axis=1, prepend=np.zeros((height, 1, 3), np.uint8)).reshape(height, -1)
    chunks = {
        b"IHDR": struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0),  # of 8 bits, RGB
        # 1: the filter of a row is Sub
        b"IDAT": zlib.compress(np.insert(steps, 0, 1, axis=1).tobytes()),
        b"IEND": b"",
    }
    parts = [
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks.items()
    ]
    return b"".join((b"\x89PNG\r\n\x1a\n", *parts))


def data_address(png: bytes) -> str:
    """The address of a PNG that is part of the page."""
    return f"data:image/png;base64,{base64.b64encode(png).decode('ascii')}"


def small_png(path: Path) -> bytes:
    """A picture in a palette of 256 colours, a fifth as large; needs Pillow."""
    images = import_optional("PIL.Image", "a report", "io")
    stream = io.BytesIO()
    with images.open(path) as image:
        image.convert("RGB").quantize(256, kmeans=2, dither=images.Dither.NONE).save(
            stream, "PNG", optimize=True
        )
    return stream.getvalue()


#: Beginning of every page; a page that somebody wrote may quote it further down.
BEGIN = "<!DOCTYPE html>\n<!-- igl_spheremap -->\n"


def page(title: str, *parts: str) -> str:
    """A whole page of parts without the empty ones; it needs no network."""
    style = files(__package__).joinpath("page.css").read_text(encoding="utf-8")
    body = "\n".join(filter(None, parts))
    return (
        f'{BEGIN}<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n{body}\n</body>\n</html>\n"
    )


def top(heading: str, command: str) -> str:
    """The heading of a page, and its maker."""
    return f"<h1>{escape(heading)}</h1>\n{made_by(command)}"


def made_by(command: str) -> str:
    """The line below a page's title: when it was made, by which version and by which command."""
    code = ""
    if command:
        code = f"<br><code>{escape(command)}</code>"
    return f'<p class="made">{datetime.now(timezone.utc):%Y-%m-%d %H:%M} UTC, igl_spheremap {__version__}{code}</p>'


def legend(shown: Ramp | tuple[str, Colour]) -> str:
    """A colour bar between the names of its ends, with its label; or one colour with its meaning."""
    if not isinstance(shown, Ramp):
        label, colour = shown
        return f'<p class="legend"><span class="swatch" style="background: {_css(colour)}"></span> {escape(label)}</p>'
    low, high, label = map(escape, (*shown.ends, shown.label))
    stops = ", ".join(map(_css, shown.stops.tolist()))
    return (
        f'<p class="legend" title="{label}">{low} <span class="bar" style="background: linear-gradient(to right, '
        f'{stops})"></span> {high}<br>{label}</p>'
    )


def _css(colour: Iterable[float]) -> str:
    return "rgb({:.0f} {:.0f} {:.0f})".format(*(255 * channel for channel in colour))


#: More faces than this would make the page larger than 20 MB.
MOST_FACES = 150_000


@dataclass(frozen=True, eq=False)
class View:
    """A surface inside the unit ball, (n, 3), its face colours (m, 3) between 0 and 1, and a caption.

    Its folded faces, by their indices, are seen however small they are; on an `image` they are drawn in front. A sphere
    can be magnified by a Moebius map.
    """

    caption: str
    x: FloatArray
    colours: FloatArray
    folded: IntArray
    shown: Ramp | tuple[str, Colour] | None = None
    sphere: bool = False
    image: bool = False


def scene(f: IntArray, views: Sequence[View]) -> str:
    """HTML with views of the same faces side by side."""
    content = {
        "faces": _base64(f, "<u4"),
        "seen": SEEN,
        "colour": _css(FOLDED),
        "views": [_content(f, view) for view in views],
    }
    code = files(__package__).joinpath("scene.js").read_text(encoding="utf-8")
    return f'<div class="scene" data-scene="{escape(json.dumps(content))}"></div><script>{code}</script>'


def _content(f: IntArray, view: View) -> dict[str, object]:
    """The input of scene.js: the surface, and, unless folded faces cover much of it, their marks."""
    painted = view.colours.copy()
    painted[view.folded] = FOLDED
    marks = Marks.of(view.x, f, view.folded, view.sphere)
    legends, nearer = "", ABOVE
    if view.shown:
        legends = legend(view.shown)
    if view.image and len(marks.clusters):
        nearer = NEARER
    return {
        "caption": view.caption,
        "legend": legends,
        "sphere": view.sphere,
        "nearer": nearer,
        "positions": _base64(view.x, "<f4"),
        "colours": _base64(np.rint(255 * painted), "u1"),
        "folded": _base64(view.folded, "<u4"),
        "starts": _base64(marks.clusters.starts, "<u4"),
        "middles": _base64(marks.middles, "<f4"),
        "outward": _base64(marks.outward, "<f4"),
        "longest": _base64(marks.longest, "<f4"),
    }


def _base64(array: NDArray[Any], kind: str) -> str:
    return base64.b64encode(array.astype(kind).tobytes()).decode("ascii")
