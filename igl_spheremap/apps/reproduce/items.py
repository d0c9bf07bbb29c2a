"""The list of what can be reproduced, and the loop that does it; importing it loads no numpy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

from ...errors import FileError, import_optional

#: Names of all tables, of all figures, of both, and one for all of them.
WRITTEN = ("table1", "table2", "table3")
DRAWN = ("fig1", "fig2", "fig3", "fig4", "fig5", "fig6", "fig7", "fig8", "fig9", "fig10")
ITEMS = (*WRITTEN, *DRAWN)
ALL = "all"
#: What figures can be written as, the default first.
PICTURES = ("png", "pdf")
#: Pixels across a PNG.
_WIDTH = 2000
#: PNGs have this many colours: no difference is seen, and they take a third of the bytes.
_COLOURS = 256
#: Shares of the colour of folded faces, at the edges of their marks.
_SHADES = (1.0, 0.75, 0.5, 0.25)
#: What is brighter is the white of the page, which means over a palette's cells would tint.
_WHITE = 250


def reproduce(
    names: Sequence[str],
    out: Path,
    *,
    meshes: Path | None = None,
    max_iterations: int | None = None,
    page: Path | None = None,
    suffix: str = PICTURES[0],
    report: Callable[[str], None] = lambda line: None,
) -> list[Path]:
    """Write the named `ITEMS` into a folder, tables as Markdown and figures as PNG or PDF; return their paths.

    Runs are kept in `out/runs` as they end: an interrupted call continues there. `meshes` is a folder of counterparts
    of the paper's surfaces; samples replace what it lacks. `max_iterations` caps each minimisation. The tables replace
    those that stand in a Markdown file, the `page`, and `out/methods.json` says by what they were made. `report` takes
    a line on each run.
    """
    # The command's help needs the names alone.
    from ...io.replacing import make_folder, replacing
    from .figures import FIGURES
    from .page import fill, read_page
    from .runs import Runs, settings
    from .tables import TABLES

    if set(names) & set(FIGURES):
        import_optional("matplotlib", "a figure", "plot")
    if meshes is not None and not meshes.is_dir():
        raise FileError(f"{meshes} is not a folder of meshes")
    text = "" if page is None else read_page(page, TABLES)
    runs = Runs(make_folder(out / "runs"), meshes, max_iterations, report)
    written: list[Path] = []
    tables: dict[str, str] = {}

    def write(path: Path, content: bytes) -> None:
        with replacing(path, force=True) as partial:
            partial.write_bytes(content)
        written.append(path)
        report(f"wrote {path}")

    for k, name in enumerate(names, 1):
        report(f"{name}, {k} of {len(names)}")
        if name in TABLES:
            tables[name] = str(TABLES[name](runs))
            write(out / f"{name}.md", tables[name].encode())
        else:
            write(out / f"{name}.{suffix}", drawn(FIGURES[name](runs), suffix))
    if page is not None:
        write(page, fill(text, tables).encode())
        write(out / "methods.json", settings().encode())
    return written


def drawn(figure: Any, suffix: str, width: int = _WIDTH) -> bytes:
    """A figure as a file; as a PNG with a palette of colours, among which are those of marks of folded faces.

    Marks are so few pixels that a palette by counts would have no place for them.
    """
    from PIL import Image  # which matplotlib needs, too

    from ...draw.palette import FOLDED, SURFACE

    full, small = BytesIO(), BytesIO()
    figure.savefig(full, format=suffix, dpi=width / figure.get_figwidth())
    if suffix != "png":
        return full.getvalue()
    image = Image.open(full).convert("RGB")
    marks = [round(255 * (k * a + (1 - k) * b)) for k in _SHADES for a, b in zip(FOLDED, SURFACE, strict=True)]
    common = (image.quantize(_COLOURS - len(_SHADES), kmeans=2).getpalette() or [])[: 3 * _COLOURS - len(marks)]
    palette = Image.new("P", (1, 1))
    palette.putpalette([*(part if part < _WHITE else 255 for part in common), *marks])
    image.quantize(palette=palette, dither=Image.Dither.NONE).save(small, format="png", optimize=True)
    return small.getvalue()
