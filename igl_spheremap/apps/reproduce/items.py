"""The list of what can be reproduced, and the loop that does it; importing it loads no numpy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ...errors import FileError, import_optional

#: Names of all tables and figures, and one for all of them.
ITEMS = ("table1", "table2", "table3", "table4", "eigenfunctions", "projections",
         "fig1", "fig2", "fig3", "fig4", "fig5", "fig6", "fig7", "fig8", "fig9", "fig10", "gradient", "eq24")
ALL = "all"


def reproduce(
    names: Sequence[str],
    out: Path,
    *,
    meshes: Path | None = None,
    max_iterations: int | None = None,
    report: Callable[[str], None] = lambda line: None,
    listen: Callable[..., Any] = lambda f: None,
) -> list[Path]:
    """Write the named `ITEMS` into a folder, tables as Markdown and figures as PNG; return their paths.

    Runs are kept in `out/runs` as they end: an interrupted call continues there. `meshes` is a folder of real
    counterparts of the paper's surfaces; samples replace what it lacks. `max_iterations` caps each minimisation.
    `report` takes a line on each run, `listen` makes a listener for a run on a mesh with these faces.
    """
    # The command's help needs the names alone.
    from ...io.replacing import replacing
    from .claims import CLAIMS
    from .figures import FIGURES
    from .runs import Runs
    from .tables import TABLES

    if set(names) & set(FIGURES):
        import_optional("matplotlib", "a figure", "plot")
    if meshes is not None and not meshes.is_dir():
        raise FileError(f"{meshes} is no folder of meshes")
    kept = out / "runs"
    try:
        kept.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"can't write {kept}: {error.strerror or error}") from error
    tables = {**TABLES, **CLAIMS}
    runs = Runs(kept, meshes, max_iterations, report, listen)
    written = []
    for name in names:
        path = out / f"{name}{'.md' if name in tables else '.png'}"
        made = tables[name](runs) if name in tables else FIGURES[name](runs)
        with replacing(path, force=True) as partial:
            if isinstance(made, str):
                partial.write_text(made, encoding="utf-8")
            else:
                made.savefig(partial, format="png")
        written.append(path)
        report(f"wrote {path}")
    return written
