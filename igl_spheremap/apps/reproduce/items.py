"""The list of what can be reproduced, and the loop that does it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from ...errors import FileError, import_optional
from ...io.replacing import replacing
from ...mesh.arrays import IntArray
from ...result.run import Listener
from .figures import FIGURES
from .runs import Runs
from .tables import TABLES


def reproduce(
    names: Sequence[str],
    out: Path,
    *,
    meshes: Path | None = None,
    max_iterations: int | None = None,
    report: Callable[[str], None] = lambda line: None,
    listen: Callable[[IntArray], Listener | None] = lambda f: None,
) -> list[Path]:
    """Write the named `ITEMS` into a folder, tables as Markdown and figures as PNG; return their paths.

    Runs are kept in `out/runs` as they end: an interrupted call continues there. `meshes` is a folder of real
    counterparts of the paper's surfaces; samples replace what it lacks. `max_iterations` caps each minimisation.
    `report` takes a line on each run, `listen` makes a listener for a run on a mesh with these faces.
    """
    if set(names) & set(FIGURES):
        import_optional("matplotlib", "a figure", "plot")
    if meshes is not None and not meshes.is_dir():
        raise FileError(f"{meshes} is no folder of meshes")
    kept = out / "runs"
    try:
        kept.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"can't write {kept}: {error.strerror or error}") from error
    runs = Runs(kept, meshes, max_iterations, report, listen)
    written = []
    for name in names:
        written.append(_write(name, out, runs))
        report(f"wrote {written[-1]}")
    return written


def _write(name: str, out: Path, runs: Runs) -> Path:
    if name in TABLES:
        path, page = out / f"{name}.md", TABLES[name].page(runs)
        with replacing(path, force=True) as partial:
            partial.write_text(page, encoding="utf-8")
    else:
        path, figure = out / f"{name}.png", FIGURES[name](runs)
        with replacing(path, force=True) as partial:
            figure.savefig(partial, format="png")
    return path
