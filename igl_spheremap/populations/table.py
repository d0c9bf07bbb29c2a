"""The table of a population: one row an input, as TSV or CSV; and its outliers."""

from __future__ import annotations

import io
import json
import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from math import nan
from typing import Any, ClassVar

import numpy as np

from ..errors import printable
from ..gate import PathLike
from ..io.tables import SEPARATORS, write_cells
from ..mesh.arrays import HALF_DIGITS, FloatArray

#: Suffixes of tables.
TABLES = tuple(SEPARATORS)
#: Errors of `from_plain` for objects that are no rows.
ROW_ERRORS = (AttributeError, KeyError, OverflowError, TypeError, ValueError)
#: Statuses of rows whose target holds a map, free of foldings or not.
MAPPED = ("certified", "folded")
#: Tukey's outer fence: interquartile ranges above the third quartile.
OUTLIER = 3.0


@dataclass(frozen=True, slots=True)
class JobRow:
    """Facts of one input and of its result.

    Attributes
    ----------
    source, target : str
        The file that was read and the first one that was written, as given.
    status : str
        "certified"; "folded": foldings remain; "no mesh": the input is not a closed genus-0 mesh; "file": a file can't
        be read or written; "failed": the computation failed or passed a limit, or its worker died.
    resumed : bool
        Whether an earlier run made it.
    vertices, foldings : int
        Of the mesh; folded faces in the file.
    seconds : float
        Wall seconds of reading, computing and writing.
    memory : float
        Peak memory of the worker's process during the job, in MB.
    worker : str
        Host and process.
    notes : str
        Further actions, or the reason for no result.
    """

    #: Figures with their labels; a larger one is worse.
    FIGURES: ClassVar[Mapping[str, str]] = {}

    source: str
    target: str
    status: str = "certified"
    resumed: bool = False
    vertices: int = 0
    foldings: int = 0
    seconds: float = 0.0
    memory: float = nan
    worker: str = ""
    notes: str = ""


@dataclass(frozen=True, slots=True)
class Row(JobRow):
    """A `JobRow` of one mesh and its map; without a map its figures are NaN.

    Attributes
    ----------
    foldings_before : int
        Folded faces before the repair.
    energy : float
        Harmonic energy, eq. (6).
    mean_angle, p99_angle, max_angle : float
        Mean, 99th percentile and maximum of the sizes of angle differences, in degrees.
    mean_area, p99_area, max_area : float
        The same of the natural logarithms of image area over source area, each surface having area 1.
    mean_edge, p99_edge, max_edge : float
        The same of the natural logarithms of image length over source length.
    stretch : float
        Limbs too deep for float64 are mapped as if up to this many times shorter; 1 if there is none.
    """

    FIGURES: ClassVar[Mapping[str, str]] = {
        "mean_angle": "mean angle", "p99_angle": "99% angle", "max_angle": "max angle",
        "mean_area": "mean log area", "p99_area": "99% log area", "max_area": "max log area",
        "mean_edge": "mean log edge", "stretch": "stretch",
    }  # fmt: skip

    foldings_before: int = 0
    energy: float = nan
    mean_angle: float = nan
    p99_angle: float = nan
    max_angle: float = nan
    mean_area: float = nan
    p99_area: float = nan
    max_area: float = nan
    mean_edge: float = nan
    p99_edge: float = nan
    max_edge: float = nan
    stretch: float = nan


@dataclass(frozen=True, slots=True)
class RegistrationRow(JobRow):
    """Facts of one hemisphere and its registration; with several templates each figure is that of the worst.

    Attributes
    ----------
    unlike : float
        1 less the mean correlation of the depth potentials of surface and template.
    mean_area, p95_area : float
        Mean and 95th percentile of the sizes of the natural logarithms of areas after the registration over
        those before.
    unsure : float
        Share of the vertices whose label has a margin below one half; NaN without labels.
    """

    FIGURES: ClassVar[Mapping[str, str]] = {
        "unlike": "1 - correlation",
        "mean_area": "mean log area",
        "p95_area": "95% log area",
        "unsure": "share of unsure labels",
    }

    unlike: float = nan
    mean_area: float = nan
    p95_area: float = nan
    unsure: float = nan


#: All kinds of rows; a table holds one kind, which is known by its columns.
_KINDS: tuple[type[JobRow], ...] = (RegistrationRow, Row)


def plain(row: JobRow) -> dict[str, Any]:
    """A row for JSON; numbers that are not finite become None.

    >>> plain(Row("a.ply", "b.ply", status="no mesh"))["energy"] is None
    True
    """
    entry = asdict(row)
    for key, value in entry.items():
        if isinstance(value, float) and not math.isfinite(value):
            entry[key] = None
    return entry


def from_plain(entry: Mapping[str, Any]) -> JobRow:
    """The row that `plain` describes; for anything else raises one of ROW_ERRORS."""
    values: dict[str, Any] = {"source": str(entry["source"]), "target": str(entry["target"])}
    kind = next((kind for kind in _KINDS if entry.keys() >= kind.FIGURES.keys()), Row)
    for field in fields(kind)[2:]:
        default: Any = field.default
        value = entry.get(field.name, default)
        if value is None and isinstance(default, float):
            value = nan
        values[field.name] = converted = type(default)(value)
        if isinstance(converted, int) and abs(converted) > sys.maxsize:
            raise ValueError(f"{field.name} has {len(str(value))} digits")
    return kind(**values)


def check_table(path: PathLike) -> None:
    """Raise a ValueError unless the name is one of a table."""
    if not str(path).lower().endswith(TABLES):
        raise ValueError(f"{printable(str(path))}: give a {' or '.join(TABLES)} file")


def write_table(path: PathLike, rows: Sequence[JobRow]) -> None:
    """Write a table; cells of numbers that are not finite are empty."""
    first: JobRow = Row("", "")
    if rows:
        first = rows[0]
    names = [field.name for field in fields(first)]
    write_cells(path, [names, *(list(plain(row).values()) for row in rows)], force=True)


def json_lines(file: io.TextIOBase | io.TextIOWrapper) -> Iterator[dict[str, Any]]:
    """The objects of a file of JSON lines, without lines that were cut off or are not JSON."""
    for line in file:
        try:
            entry = json.loads(line)
        except (ValueError, RecursionError):
            continue
        if isinstance(entry, dict):
            yield entry


def figures_of(rows: Sequence[JobRow]) -> Mapping[str, str]:
    """Names and labels of the figures of a table's rows."""
    if not rows:
        return Row.FIGURES
    return rows[0].FIGURES


def excess(rows: Sequence[JobRow]) -> FloatArray:
    """Distance of the figures (rows, figures) above the third quartile, in interquartile ranges.

    NaN counts as 0; if the range is 0, values above it lie infinitely far.

    >>> excess([Row("", "", mean_angle=angle) for angle in (1, 2, 3, 4, 5, 20)])[:, 0].round(1).tolist()
    [-1.5, -1.1, -0.7, -0.3, 0.1, 6.1]
    """
    beyond = np.zeros((len(rows), len(figures_of(rows))))
    for k, (column, low, high) in enumerate(_quartiles(rows)):
        with np.errstate(divide="ignore", invalid="ignore"):
            beyond[:, k] = np.nan_to_num(
                (column - high) / (high - low), posinf=np.inf, neginf=-np.inf
            )
    return beyond


def fences(rows: Sequence[JobRow]) -> dict[str, float]:
    """Limits of the figures: values above by more than rounding are outliers."""
    return {
        name: (high + OUTLIER * (high - low)) * (1 + HALF_DIGITS)
        for name, (_, low, high) in zip(figures_of(rows), _quartiles(rows), strict=True)
    }


def outlying(row: JobRow, limits: Mapping[str, float]) -> list[str]:
    """Names of the figures of a row that are outliers, the farthest above its limit first."""
    found = [name for name in row.FIGURES if getattr(row, name) > limits[name]]
    return sorted(
        found, key=lambda name: -getattr(row, name) / max(limits[name], sys.float_info.min)
    )


def _quartiles(rows: Sequence[JobRow]) -> Iterator[tuple[FloatArray, float, float]]:
    """The values of each figure, and the first and third quartile of the finite ones."""
    for name in figures_of(rows):
        column = np.array([getattr(row, name) for row in rows], dtype=np.float64)
        finite = column[np.isfinite(column)]
        low = high = nan
        if len(finite):
            low, high = np.percentile(finite, [25, 75]).tolist()
        yield column, low, high


def worst_first(rows: Sequence[JobRow]) -> list[int]:
    """Indices of rows: those without a map, those with foldings, then by the largest excess of a figure."""
    beyond = excess(rows).max(axis=1, initial=-np.inf)
    mapless = [row.status not in MAPPED for row in rows]
    return sorted(range(len(rows)), key=lambda k: (not mapless[k], -rows[k].foldings, -beyond[k]))
