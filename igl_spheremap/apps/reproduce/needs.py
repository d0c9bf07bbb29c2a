"""Which runs tables and figures are made of, so that it is known before they start how long they take."""

from __future__ import annotations

from collections.abc import Iterator

from .claims import runs_of_projections, runs_of_table_4
from .figures import FIG_10, TO_THE_FLOOR, dinosaurs
from .runs import PaperRun, Runs
from .surfaces import all_surfaces
from .tables import TABLE_1, WAYS, lines

_TABLE_1 = tuple(row.surface for row in TABLE_1)
#: Surfaces and methods of items.
_RUNS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "boosts": (_TABLE_1, ("default",)),
    "fig1": (("Brain",), ("default",)),
    "fig3": (_TABLE_1, ("Algorithm 1 as printed",)),
    "fig4": (_TABLE_1, ("Algorithm 1 as printed",)),
    "fig10": (FIG_10, ("Gu-Yau", "Algorithm 2 made safe")),
    "gradient": (TO_THE_FLOOR, ("Algorithm 1 without a stopping rule",)),
    "eq24": (_TABLE_1, ("default",)),
}
#: Methods that run on the dinosaurs.
_DINOSAURS: dict[str, tuple[str, ...]] = {
    "fig5": ("Algorithm 2 as printed",),
    "fig7": ("Algorithm 2 made safe",),
    "fig9": ("Algorithm 2 as printed", "Algorithm 2 made safe"),
}


def runs_of(name: str, runs: Runs) -> Iterator[PaperRun]:
    """All runs that a table or figure takes."""
    if name in WAYS:
        rows, algorithm, ways = WAYS[name]
        for line in lines(runs, rows, algorithm):
            yield from line.planned(ways)
    elif name == "table4":
        yield from runs_of_table_4(runs)
    elif name == "projections":
        yield from runs_of_projections(runs)
    elif name == "eigenfunctions":
        yield from (runs.plan(surface, "default") for surface in all_surfaces(runs.meshes))
    surfaces, methods = _RUNS.get(name, ((), ()))
    yield from (runs.plan(runs.surface(surface), method) for surface in surfaces for method in methods)
    yield from (runs.plan(surface, method) for method in _DINOSAURS.get(name, ())
                for surface in (dinosaurs(runs) if name == "fig5" else [runs.surface("Dino", sample=True)]))
