"""Pages of sentences between which tables stand that runs have written, and pictures in few bytes."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from igl_spheremap.draw.palette import FOLDED, SURFACE

_BLOCK = re.compile(r"(<!-- table (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)
#: PNGs have this many colours: no difference is seen, and they take a third of the bytes.
_COLOURS = 256
#: Shares of the colour of folded faces, at the edges of their marks.
_SHADES = (1.0, 0.75, 0.5, 0.25)
#: What is brighter is the white of the page, which means over a palette's cells would tint.
_WHITE = 250


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
        return (
            f"{begin}{tables[name].partition(chr(10) * 2)[2]}{end}"
            if name in tables
            else block.group()
        )

    return _BLOCK.sub(filled, page)


def reduce(path: Path) -> None:
    """Give a PNG a palette of colours, among which are those of marks of folded faces.

    Marks are so few pixels that a palette by counts would have no place for them.
    """
    from PIL import Image  # which matplotlib needs, too

    image = Image.open(path).convert("RGB")
    marks = [
        round(255 * (k * a + (1 - k) * b))
        for k in _SHADES
        for a, b in zip(FOLDED, SURFACE, strict=True)
    ]
    common = (image.quantize(_COLOURS - len(_SHADES), kmeans=2).getpalette() or [])[
        : 3 * _COLOURS - len(marks)
    ]
    palette = Image.new("P", (1, 1))
    palette.putpalette([*(part if part < _WHITE else 255 for part in common), *marks])
    image.quantize(palette=palette, dither=Image.Dither.NONE).save(
        path, format="png", optimize=True
    )
