"""HTML pages in files: their paths, files that they may replace, and texts, whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path

from ..draw.markup import BEGIN, page
from ..errors import FileError, printable
from ..gate import PathLike
from .replacing import replacing


def write_page(path: Path, title: str, *parts: str) -> None:
    """Write a page of these parts."""
    write_html(path, page(title, *parts))


def write_html(path: Path, text: str) -> None:
    """Write the text of a page, in the place of an earlier one."""
    check_own_page(path)
    with replacing(path, force=True) as partial:
        partial.write_text(text, encoding="utf-8", errors="backslashreplace")


def check_own_page(path: Path) -> None:
    """Raise a FileError if there is a file that is not a page of an earlier report."""
    begin = BEGIN.encode()
    if path.is_file():
        with path.open("rb") as file:
            if file.read(len(begin)) == begin:
                return
    if path.exists():
        raise FileError(
            f"{path} is not a page of an earlier report, and is kept; give another place for the report"
        )


def page_file(place: PathLike, name: str) -> Path:
    """The file of a page: `place` if it ends in .html, else `name` in that folder. A ValueError names other endings.

    >>> page_file("a/bunny.html", "report.html").name, page_file("a", "report.html").name
    ('bunny.html', 'report.html')
    """
    path = Path(place)
    if path.suffix.lower() == ".html" and not path.is_dir():
        return path
    folder = path.is_dir() or str(place).endswith(("/", os.sep)) or not path.suffix
    if not folder or path.is_file():
        raise ValueError(
            f"{printable(str(place))}: give a file that ends in .html, or a folder, whose name has no ending or "
            "ends in /"
        )
    return path / name
