"""Print the quantiles and the outliers of many maps.

    igl-spheremap summarise white.tsv
"""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ....populations.statistics import FIGURES, OUTLIER, excess, worst_first
from ....populations.table import Row, read_table
from ..exits import Exit
from ..failures import with_flags
from ..output import row as paragraph

STATUS = {"certified": Exit.OK, "no mesh": Exit.NO_MESH, "folded": Exit.UNCERTIFIED, "failed": Exit.FAILED,
          "file": Exit.FILE}
_COSTS = {"seconds": "seconds", "memory": "memory in MB"}
_QUANTILES = (0, 25, 50, 75, 99, 100)
_SHOWN = 20


def run(args: Namespace) -> None:
    """Print counts, quantiles and outliers."""
    rows = read_table(args.table)
    print(counts(rows, len(rows)), *_quantiles(rows), *_outliers(rows), sep="\n", flush=True)


def with_flags_in_notes(rows: Sequence[Row]) -> list[Row]:
    """Rows whose notes name flags in the place of the library's calls."""
    return [replace(row, notes=with_flags(row.notes)) for row in rows]


def counts(rows: Sequence[Row], total: int) -> str:
    """Counts over the files that were given, and the first ones without a certified sphere."""
    bad = [row for row in rows if row.status != "certified"]
    resumed = sum(row.resumed for row in rows)
    there = f", {resumed} were there already" if resumed else ""
    lines = [paragraph("certified", f"{len(rows) - len(bad)} of {total} files{there}")]
    for row in bad[:_SHOWN]:
        reason = row.notes.removeprefix(f"{row.source}: ") or f"{row.foldings} foldings remain"
        lines.append(paragraph(row.status, f"{row.source}: {reason}"))
    if len(bad) > _SHOWN:
        lines.append(paragraph("", f"and {len(bad) - _SHOWN} more"))
    if len(rows) < total:
        lines.append(paragraph("interrupted", f"{total - len(rows)} files are left; run it again to continue"))
    return "\n".join(lines)


def _quantiles(rows: Sequence[Row]) -> list[str]:
    """A table of the figures of all maps."""
    lines = ["", f"  {'':<18}" + "".join(f"{q:>9}%" for q in _QUANTILES)]
    for name, label in (FIGURES | _COSTS).items():
        values = np.array([getattr(row, name) for row in rows], dtype=np.float64)
        values = values[np.isfinite(values)]
        if len(values):
            lines.append(f"  {label:<18}" + "".join(f"{value:>10.4g}" for value in np.percentile(values, _QUANTILES)))
    return lines


def _outliers(rows: Sequence[Row]) -> list[str]:
    """Maps of which a figure is far above those of the others."""
    beyond = excess(rows)
    found = [k for k in worst_first(rows) if beyond[k].max() > OUTLIER]
    lines = ["", paragraph("outliers", f"{len(found)} of {len(rows)} files: a figure more than {OUTLIER:g} "
                                       "interquartile ranges above the third quartile")]
    labels = list(FIGURES.items())
    for k in found[:_SHOWN]:
        name, label = labels[int(beyond[k].argmax())]
        lines.append(paragraph("", f"{rows[k].source}: {label} {getattr(rows[k], name):.4g}"))
    return lines
