"""A page of sentences between which tables stand that runs have written."""

from __future__ import annotations

import re
from collections.abc import Mapping

from ...errors import FileError

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


def check_page(page: str, known: Mapping[str, object], path: object) -> None:
    """Raise a FileError for a page that asks for no table, or for one that does not exist."""
    asked = [name for _, name, _ in _BLOCK.findall(page)]
    unknown = [name for name in asked if name not in known]
    if not asked or unknown:
        what = f"a table {unknown[0]!r}, which does not exist" if unknown else "no table"
        raise FileError(f"{path} asks for {what}; write <!-- table NAME --> and <!-- end --> on lines of their own, "
                        f"where NAME is one of {', '.join(known)}")
