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
    """The text of a page; a FileError if it asks for no table, for one that does not exist, or can't be written."""
    try:
        page = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(f"can't read {path}: {getattr(error, 'strerror', None) or 'it is not UTF-8'}") from error
    asked = [name for _, name, _ in _BLOCK.findall(page)]
    unknown = [name for name in asked if name not in known]
    if not asked or unknown:
        what = f"a table {unknown[0]!r}, which does not exist" if unknown else "no table"
        raise FileError(f"{path} asks for {what}; write <!-- table NAME --> and <!-- end --> on lines of their own, "
                        f"where NAME is one of {', '.join(known)}")
    check_writable(path, force=True)
    return page
