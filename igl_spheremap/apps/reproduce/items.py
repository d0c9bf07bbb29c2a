"""The list of what can be reproduced, and the loop that does it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...descent.iterate import Listener
from ...errors import FileError, import_optional
from ...io.replacing import replacing
from .curves import figure_4
from .pictures import figure_3, figure_5, figure_6, figure_9, figure_10
from .runs import Runs
from .surfaces import check_folder
from .tables import table_1, table_2, table_3

_TABLES: dict[str, Callable[[Runs, Path | None], Any]] = {
    "table1": table_1,
    "table2": table_2,
    "table3": table_3,
}
_FIGURES: dict[str, Callable[[Runs, Path | None], Any]] = {
    "fig3": figure_3,
    "fig4": figure_4,
    "fig5": figure_5,
    "fig6": figure_6,
    "fig9": figure_9,
    "fig10": figure_10,
}

#: Names of all tables and figures.
ITEMS = (*_TABLES, *_FIGURES)


def reproduce(
    names: Sequence[str],
    out: Path,
    *,
    meshes: Path | None = None,
    max_iterations: int | None = None,
    report: Callable[[str], None] = lambda line: None,
    listen: Callable[[NDArray[np.int64]], Listener | None] = lambda f: None,
) -> list[Path]:
    """Write the named `ITEMS` into a folder, tables as Markdown and figures as PNG; return their paths.

    Runs are kept in `out/runs` as they end: an interrupted call continues there. `meshes` is a folder of real
    counterparts of the paper's surfaces; samples replace what it lacks. `max_iterations` caps each minimisation.
    `report` takes a line on each run, `listen` gives a listener for a run on a mesh with these faces.
    """
    unknown = sorted(set(names) - set(ITEMS))
    if unknown:
        raise ValueError(f"nothing is called {', '.join(unknown)}: choose of {', '.join(ITEMS)}")
    if set(names) & set(_FIGURES):
        import_optional("matplotlib", "a figure", "plot")
    check_folder(meshes)
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"can't write {out}: {error.strerror or error}") from error
    runs = Runs(out / "runs", max_iterations, report, listen)
    written = []
    for name in names:
        path = out / f"{name}.{'md' if name in _TABLES else 'png'}"
        made = (_TABLES if name in _TABLES else _FIGURES)[name](runs, meshes)
        with replacing(path, force=True) as partial:
            if name in _TABLES:
                partial.write_text(made, encoding="utf-8")
            else:
                made.savefig(partial, format="png")
        report(f"wrote {path}")
        written.append(path)
    return written
