"""A page of sentences between which tables stand that runs have written."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from ...errors import FileError
from ...io.replacing import check_writable

_BLOCK = re.compile(r"(<!-- table (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)


def fill(page: str, tables: Mapping[str, str]) -> str:
    """The page with the text of each table, less its title, between ``<!-- table NAME -->`` and ``<!-- end -->``.

    Tables that are not given stay as they are.

    >>> print(fill("Before\\n<!-- table one -->\\nold\\n<!-- end -->\\nafter", {"one": "# Title\\n\\nnew\\n"}))
    Before
    <!-- table one -->
    new
    <!-- end -->
    after
    """
    def filled(block: re.Match[str]) -> str:
        begin, name, end = block.groups()
        return f"{begin}{without_title(tables[name])}{end}" if name in tables else block.group()

    return _BLOCK.sub(filled, page)


def without_title(table: str) -> str:
    """A table's text from its second paragraph on."""
    return table.partition("\n\n")[2]


def read_page(path: Path, known: Mapping[str, object]) -> str:
    """The text of a page; a FileError if it asks for none of the tables, or can't be written."""
    try:
        page = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(f"can't read {path}: {getattr(error, 'strerror', None) or 'it is not UTF-8'}") from error
    if not {name for _, name, _ in _BLOCK.findall(page)} & set(known):
        raise FileError(f"{path} asks for none of the tables; write <!-- table NAME --> and <!-- end --> on lines of "
                        f"their own, where NAME is one of {', '.join(known)}")
    check_writable(path, force=True)
    return page
