"""HTML for notebooks and reports: tables, pictures, and surfaces that the reader can turn (WebGL, no download)."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

from ..mesh.arrays import FloatArray, IntArray


def table(rows: Iterable[Sequence[str]], header: Sequence[str] = ()) -> str:
    """A table of texts, which are escaped; without a header the first cell of each row is its label.

    >>> table([("a", "x < y")])
    '<table><tr><th scope="row">a</th><td>x &lt; y</td></tr></table>'
    """
    head = "".join(f'<th scope="col">{escape(cell)}</th>' for cell in header)
    lines = [f"<tr>{head}</tr>"] if header else []
    for row in rows:
        cells = [f"<td>{escape(cell)}</td>" for cell in row]
        if not header:
            cells[0] = f'<th scope="row">{escape(row[0])}</th>'
        lines.append(f"<tr>{''.join(cells)}</tr>")
    return f"<table>{''.join(lines)}</table>"


def picture(png: bytes, caption: str) -> str:
    """A PNG as part of the page, with a caption."""
    data = base64.b64encode(png).decode("ascii")
    text = escape(caption)
    return f'<figure><img alt="{text}" src="data:image/png;base64,{data}"><figcaption>{text}</figcaption></figure>'


def page(title: str, body: str) -> str:
    """A whole page around a body; it needs no other file and no network."""
    style = files(__package__).joinpath("page.css").read_text(encoding="utf-8")
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n{body}\n</body>\n</html>\n"
    )


#: More faces than this would make the page larger than 20 MB.
MOST_FACES = 150_000


@dataclass(frozen=True, eq=False)
class View:
    """A surface inside the unit ball, (n, 3), its face colours (m, 3) between 0 and 1, and a caption.

    A sphere can be magnified by a Moebius map.
    """

    caption: str
    x: FloatArray
    colours: FloatArray
    sphere: bool = False


def scene(f: IntArray, views: Sequence[View]) -> str:
    """HTML with views of the same faces side by side."""
    content = {
        "faces": _base64(f.astype("<u4")),
        "views": [
            {
                "caption": view.caption,
                "sphere": view.sphere,
                "positions": _base64(view.x.astype("<f4")),
                "colours": _base64(np.rint(255 * view.colours).astype(np.uint8)),
            }
            for view in views
        ],
    }
    code = files(__package__).joinpath("scene.js").read_text(encoding="utf-8")
    return f'<div class="scene" data-scene="{escape(json.dumps(content))}"></div><script>{code}</script>'


def _base64(array: NDArray[np.generic]) -> str:
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")
