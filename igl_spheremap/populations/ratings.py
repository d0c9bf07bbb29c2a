"""What people said of results on a page, which it saves as a table."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ..errors import MeshError
from ..io.reading import reading
from ..io.tables import SEPARATORS, read_cells

#: Those that a page offers.
PASS, FAIL = "pass", "fail"


@dataclass(frozen=True, slots=True)
class Rating:
    """Pass or fail, and a comment."""

    rating: str
    comment: str = ""

    def __str__(self) -> str:
        return f"rated {self.rating}" + (f": {self.comment}" if self.comment else "")


def read_ratings(path: str | os.PathLike[str], sources: Sequence[str]) -> dict[str, Rating]:
    """The ratings in a table of those sources that have one.

    Raises a MeshError if the table holds none of these, or is not a table of ratings.
    """
    path = Path(path)
    with reading(path):
        if path.suffix.lower() not in SEPARATORS:
            raise MeshError("ratings are kept in .tsv and .csv files")
        header, *lines = read_cells(path)
        rows = [dict(zip(header, line, strict=False)) for line in lines]
        if not {"source", "rating"} <= set(header):
            raise MeshError("it has no columns 'source' and 'rating'; give a file that a page saved")
        wrong = [row for row in rows if row["rating"] not in ("", PASS, FAIL)]
        if wrong:
            raise MeshError(f"{wrong[0]['source']} is rated {wrong[0]['rating']!a}; give {PASS} or {FAIL}")
        given = {os.path.realpath(row["source"]): Rating(row["rating"], row.get("comment") or "")
                 for row in rows if row["rating"]}
        found = {source: given[place] for source in sources if (place := os.path.realpath(source)) in given}
        if given and not found:
            raise MeshError(f"it rates {len(given)} files, e.g. {next(iter(given))}, and none of the {len(sources)} "
                            "here; run from the folder in which the page was made, or give its files")
        return found
