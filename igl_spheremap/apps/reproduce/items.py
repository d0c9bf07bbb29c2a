"""The list of what can be reproduced, and the loop that does it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ...errors import FileError
from ...io.replacing import replacing
from .curves import figure_4
from .pictures import figure_3, figure_5, figure_6, figure_9, figure_10
from .runs import Runs
from .surfaces import check_folder
from .tables import table_1, table_2, table_3

_TABLES: dict[str, Callable[[Runs, Path | None], str]] = {
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
    tell: Callable[[str], None] = lambda line: None,
) -> list[Path]:
    """Compute tables and figures of the paper anew.

    Runs are kept in ``out/runs`` as they end, so that an interrupted call goes on where it was.

    Parameters
    ----------
    names : sequence of str
        Of `ITEMS`.
    out : Path
        Folder for the results; made if it is not there.
    meshes : Path, optional
        Folder of real counterparts of the paper's surfaces; samples stand in for what it lacks.
    max_iterations : int, optional
        Cap on the iterations of each minimisation; by default the methods' own.
    tell : callable
        Takes lines on what is going on.

    Returns
    -------
    list of Path
        The files, a Markdown page for each table and a PNG for each figure.

    Raises
    ------
    FileError
        If a folder can't be read or written, or matplotlib is wanted and not installed.
    ValueError
        If a name is unknown.
    """
    unknown = sorted(set(names) - set(ITEMS))
    if unknown:
        raise ValueError(f"nothing is called {', '.join(unknown)}: choose of {', '.join(ITEMS)}")
    check_folder(meshes)
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"can't write {out}: {error.strerror or error}") from error
    runs = Runs(out / "runs", max_iterations, tell)
    written = []
    for name in names:
        path = out / f"{name}.{'md' if name in _TABLES else 'png'}"
        if name in _TABLES:
            page = _TABLES[name](runs, meshes)
            with replacing(path, force=True) as partial:
                partial.write_text(page, encoding="utf-8")
        else:
            figure = _FIGURES[name](runs, meshes)
            with replacing(path, force=True) as partial:
                figure.savefig(partial, format="png")
        tell(f"wrote {path}")
        written.append(path)
    return written
