"""HTML, as much of it as notebooks and reports need."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from html import escape


def table(rows: Iterable[Sequence[str]], header: Sequence[str] = ()) -> str:
    """A table of texts.

    Parameters
    ----------
    rows : iterable of sequence of str
        Its cells; without a header the first of each row is a label.
    header : sequence of str
        Over the columns.

    Returns
    -------
    str
        HTML; all texts are escaped.

    Examples
    --------
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
    """A picture that is part of the page.

    Parameters
    ----------
    png : bytes
        A PNG file.
    caption : str
        Under it, and in its place where it can't be seen.

    Returns
    -------
    str
        HTML.
    """
    data = base64.b64encode(png).decode("ascii")
    text = escape(caption)
    return f'<figure><img alt="{text}" src="data:image/png;base64,{data}"><figcaption>{text}</figcaption></figure>'


def page(title: str, style: str, body: str) -> str:
    """A whole page.

    Parameters
    ----------
    title : str
        Of the window.
    style : str
        CSS.
    body : str
        HTML.

    Returns
    -------
    str
        HTML that needs no other file and no network.
    """
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{style}</style>\n</head>\n<body>\n{body}\n</body>\n</html>\n"
    )
