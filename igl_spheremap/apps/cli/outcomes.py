"""What became of the files of a batch: one line each, for machines and for people."""

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
    """One line of the summary.

    Attributes
    ----------
    source, target : str
        The file, and where its sphere is.
    status : int
        As `igl-spheremap map` would have ended.
    resumed : bool
        The sphere was there already, and was certified only.
    vertices, foldings : int
        Of the mesh; folded and degenerate faces of the sphere as written.
    energy, mean_angle, max_angle : float
        Harmonic energy, and angle differences in degrees; NaN where there is no map.
    seconds : float
        Of the mapping.
    message : str
        Why there is no map.
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
    seconds: float = 0.0
    message: str = ""


def table(outcomes: Sequence[Outcome], comma: bool) -> str:
    """The summary as CSV or as JSON lines.

    Parameters
    ----------
    outcomes : sequence of Outcome
        In the order of the lines.
    comma : bool
        CSV, with a header; JSON lines otherwise.

    Returns
    -------
    str
        What is not finite is left empty, or null.

    Examples
    --------
    >>> table([Outcome("a.ply", "b.ply", status=2)], comma=False)[:50]
    '{"source": "a.ply", "target": "b.ply", "status": 2'
    """
    plain = [{k: _finite(value) for k, value in asdict(outcome).items()} for outcome in outcomes]
    if not comma:
        return "".join(json.dumps(entry) + "\n" for entry in plain)
    text = io.StringIO()
    writer = csv.DictWriter(text, [field.name for field in fields(Outcome)], lineterminator="\n")
    writer.writeheader()
    writer.writerows(plain)
    return text.getvalue()


def summary(outcomes: Sequence[Outcome], total: int) -> str:
    """Counts, and the first files that have no certified sphere.

    Parameters
    ----------
    outcomes : sequence of Outcome
        Of the files that were worked on.
    total : int
        Number of files that were given.

    Returns
    -------
    str
        Some lines.
    """
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
        lines.append(row("interrupted", f"{total - len(outcomes)} files are left; run it again to go on"))
    return "\n".join(lines)


def _finite(value: object) -> object:
    if isinstance(value, Exit):
        return int(value)
    return None if isinstance(value, float) and not math.isfinite(value) else value
