"""The outcomes of a batch: one line a file, for programs and for people."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields

from .exits import Exit
from .output import row

_FAULTS_SHOWN = 20


@dataclass(frozen=True)
class Outcome:
    """One line of the summary; NaN where there is no map.

    Angles are in degrees, areas logarithms of image over source, seconds those of the mapping.

    The status is that of `igl-spheremap map`; `resumed` means that the target was there and only certified.
    """

    source: str
    target: str
    status: int = Exit.OK
    resumed: bool = False
    vertices: int = 0
    foldings: int = 0
    energy: float = math.nan
    mean_angle: float = math.nan
    max_angle: float = math.nan
    mean_area: float = math.nan
    seconds: float = 0.0
    message: str = ""


def table(outcomes: Sequence[Outcome], comma: bool) -> str:
    """The summary as CSV with a header, or as JSON lines; what is not finite is left empty, or null.

    >>> table([Outcome("a.ply", "b.ply", status=2)], comma=False)[:50]
    '{"source": "a.ply", "target": "b.ply", "status": 2'
    """
    plain = [{k: _finite(value) for k, value in asdict(outcome).items()} for outcome in outcomes]
    if not comma:
        return "".join(json.dumps(entry) + "\n" for entry in plain)
    text = io.StringIO()
    writer = csv.DictWriter(text, [field.name for field in fields(Outcome)], lineterminator="\n")
    writer.writeheader()
    writer.writerows({key: _as_text(value) for key, value in entry.items()} for entry in plain)
    return text.getvalue()


def summary(outcomes: Sequence[Outcome], total: int) -> str:
    """Counts over the files that were given, and the first ones without a certified sphere."""
    good = [outcome for outcome in outcomes if outcome.status == Exit.OK]
    bad = [outcome for outcome in outcomes if outcome.status != Exit.OK]
    resumed = sum(outcome.resumed for outcome in outcomes)
    lines = [row("certified", f"{len(good)} of {total} files" + (f", {resumed} were there already" if resumed else ""))]
    for outcome in bad[:_FAULTS_SHOWN]:
        reason = outcome.message.removeprefix(f"{outcome.source}: ") or f"{outcome.foldings} foldings remain"
        lines.append(row(f"status {int(outcome.status)}", f"{outcome.source}: {reason}"))
    if len(bad) > _FAULTS_SHOWN:
        lines.append(row("", f"and {len(bad) - _FAULTS_SHOWN} more"))
    if len(outcomes) < total:
        lines.append(row("interrupted", f"{total - len(outcomes)} files are left; run it again to continue"))
    return "\n".join(lines)


def _as_text(value: object) -> object:
    """A cell that no spreadsheet takes for a formula."""
    return f"'{value}" if isinstance(value, str) and value.startswith(("=", "+", "-", "@", "\t", "\r")) else value


def _finite(value: object) -> object:
    if isinstance(value, Exit):
        return int(value)
    return None if isinstance(value, float) and not math.isfinite(value) else value
