"""The list of what can be reproduced, and the loop that does it; importing it loads no numpy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

from ...errors import FileError, import_optional

#: Names of all tables, of which the first have runs that can be repeated, of all figures, and one for all of both.
REPEATED = ("table1", "table2", "table3")
WRITTEN = (*REPEATED, "table4", "eigenfunctions", "projections", "boosts")
ITEMS = (*WRITTEN, "fig1", "fig2", "fig3", "fig4", "fig5", "fig6", "fig7", "fig8", "fig9", "fig10", "gradient", "eq24")
ALL = "all"
#: Renumbered copies of a surface that show what rounding alone changes.
COPIES = 5
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
    spread: bool = False,
    page: Path | None = None,
    report: Callable[[str], None] = lambda line: None,
    listen: Callable[..., Any] = lambda f: None,
) -> list[Path]:
    """Write the named `ITEMS` into a folder, tables as Markdown and figures as PNG; return their paths.

    Runs are kept in `out/runs` as they end: an interrupted call continues there. `meshes` is a folder of real
    counterparts of the paper's surfaces; samples replace what it lacks. `max_iterations` caps each minimisation.
    With `spread` runs of Tables 1 to 3 are repeated on renumbered copies. The tables replace those that stand in a
    Markdown file, the `page`, and `out/methods.json` says by what they were made. `report` takes a line on each run,
    `listen` makes a listener for a run on a mesh with these faces.
    """
    # The command's help needs the names alone.
    from ...io.replacing import make_folder, replacing
    from .claims import CLAIMS
    from .figures import FIGURES
    from .needs import runs_of
    from .page import fill, read_page
    from .runs import Runs, settings
    from .tables import TABLES

    if set(names) & set(FIGURES):
        import_optional("matplotlib", "a figure", "plot")
    if meshes is not None and not meshes.is_dir():
        raise FileError(f"{meshes} is not a folder of meshes")
    makers = {**TABLES, **CLAIMS}
    text = "" if page is None else read_page(page, makers)
    runs = Runs(make_folder(out / "runs"), meshes, max_iterations, COPIES if spread else 0, report, listen)
    report("reading the surfaces")
    if "projections" in names:
        report("projections in a row take some ten minutes, besides the runs")
    runs.announce(one for name in names for one in runs_of(name, runs))
    written: list[Path] = []
    tables: dict[str, str] = {}

    def write(path: Path, content: bytes) -> None:
        with replacing(path, force=True) as partial:
            partial.write_bytes(content)
        written.append(path)
        report(f"wrote {path}")

    for name in names:
        if name in makers:
            tables[name] = str(makers[name](runs))
            write(out / f"{name}.md", tables[name].encode())
        else:
            write(out / f"{name}.png", _picture(FIGURES[name](runs)))
    if page is not None:
        write(page, fill(text, tables).encode())
        write(out / "methods.json", settings().encode())
    return written


def _picture(figure: Any) -> bytes:
    """A figure as a PNG file with a palette of colours, among which are those of marks of folded faces.

    Marks are so few pixels that a palette by counts would have no place for them.
    """
    from PIL import Image  # which matplotlib needs, too

    from ...draw.palette import FOLDED, SURFACE

    full, small = BytesIO(), BytesIO()
    figure.savefig(full, format="png")
    image = Image.open(full).convert("RGB")
    marks = [round(255 * (k * a + (1 - k) * b)) for k in _SHADES for a, b in zip(FOLDED, SURFACE, strict=True)]
    common = (image.quantize(_COLOURS - len(_SHADES), kmeans=2).getpalette() or [])[: 3 * _COLOURS - len(marks)]
    palette = Image.new("P", (1, 1))
    palette.putpalette([*(part if part < _WHITE else 255 for part in common), *marks])
    image.quantize(palette=palette, dither=Image.Dither.NONE).save(small, format="png", optimize=True)
    return small.getvalue()
