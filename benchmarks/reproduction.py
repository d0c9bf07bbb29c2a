"""Compute the tables and figures of docs/reproduction anew, and write the tables into docs/reproduction.md.

    python -m benchmarks reproduction --meshes meshes

Runs are kept as they end; run it again to continue.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

from igl_spheremap.apps.reproduce.items import ITEMS, reproduce
from igl_spheremap.apps.reproduce.runs import METHODS

from .common import DOCS, parser
from .pages import fill, reduce

OUT, PAGE = DOCS / "reproduction", DOCS / "reproduction.md"


def settings() -> str:
    """All methods with their options, as JSON: what tables were made by is known from it."""
    return (
        json.dumps(
            {name: asdict(method) for name, method in METHODS.items()}, indent=1, sort_keys=True
        )
        + "\n"
    )


def main(argv: list[str]) -> None:
    """Make them, and say by which settings."""
    arguments = parser(__doc__)
    arguments.add_argument(
        "--meshes", type=Path, required=True, help="counterparts of the paper's surfaces"
    )
    written = reproduce(ITEMS, OUT, meshes=arguments.parse_args(argv).meshes, report=print)
    for path in written:
        if path.suffix == ".png":
            reduce(path)
    tables = {path.stem: path.read_text("utf-8") for path in written if path.suffix == ".md"}
    PAGE.write_text(fill(PAGE.read_text("utf-8"), tables), encoding="utf-8")
    (OUT / "methods.json").write_text(settings(), encoding="utf-8")
