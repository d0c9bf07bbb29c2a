"""The list of reproducible items, and the loop that makes them; importing it loads no numpy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from ...errors import FileError, import_optional

#: Names of all tables and figures, and one for all of them.
ITEMS = ("table1", "table2", "table3", *(f"fig{k}" for k in range(1, 11)))
ALL = "all"


def reproduce(
    names: Sequence[str],
    out: Path,
    *,
    meshes: Path | None = None,
    max_iterations: int | None = None,
    report: Callable[[str], None] = lambda line: None,
    width: int = 2000,
) -> list[Path]:
    """Write the named `ITEMS` into a folder, tables as Markdown and figures as PNG; return their paths.

    Runs are kept in `out/runs` as they end: an interrupted call continues there. `meshes` is a folder of counterparts
    of the paper's surfaces; samples replace what it lacks. `max_iterations` caps each minimisation. `report` takes a
    line on each run. Figures are `width` pixels across.
    """
    # The command's help needs the names alone.
    from ...io.replacing import make_folder, replacing
    from .figures import FIGURES
    from .runs import Runs
    from .tables import TABLES

    if set(names) & set(FIGURES):
        import_optional("matplotlib", "a figure", "plot")
    if meshes is not None and not meshes.is_dir():
        raise FileError(f"{meshes} is not a folder of meshes")
    runs = Runs(make_folder(out / "runs", follow=False), meshes, max_iterations, report)
    written: list[Path] = []
    for k, name in enumerate(names, 1):
        report(f"{name}, {k} of {len(names)}")
        path = out / f"{name}.png"
        if name in TABLES:
            path = path.with_suffix(".md")
        with replacing(path, force=True) as partial:
            if name in TABLES:
                partial.write_text(TABLES[name](runs), encoding="utf-8")
            else:
                figure = FIGURES[name](runs)
                figure.savefig(partial, format="png", dpi=width / figure.get_figwidth())
        written.append(path)
        report(f"wrote {path}")
    return written
