"""People's ratings of results on a page, which it saves as a table."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from ..errors import MeshError
from ..gate import PathLike
from ..io.reading import reading
from ..io.tables import SEPARATORS, read_cells

#: Ratings that a page offers.
_PASS, _FAIL = "pass", "fail"


def failed_in(path: PathLike, sources: Sequence[str]) -> dict[str, str]:
    """The sources that a table of ratings calls failed, each with its comment.

    If the table rates none of these, or is not a table of ratings, raises a MeshError.
    """
    path = Path(path)
    with reading(path):
        if path.suffix.lower() not in SEPARATORS:
            raise MeshError("ratings are kept in .tsv and .csv files")
        header, *lines = read_cells(path)
        if not {"source", "rating"} <= set(header):
            raise MeshError(
                "it has no columns 'source' and 'rating'; give a file that a page saved"
            )
        rated = {}
        for line in lines:
            row = dict(zip(header, line, strict=False))
            if row["rating"] not in ("", _PASS, _FAIL):
                raise MeshError(
                    f"{row['source']} is rated {row['rating']!a}; give {_PASS} or {_FAIL}"
                )
            if row["rating"]:
                rated[os.path.realpath(row["source"])] = row
        places = {source: os.path.realpath(source) for source in sources}
        found = {source: rated[place] for source, place in places.items() if place in rated}
        if rated and not found:
            raise MeshError(
                f"it rates {len(rated)} files, e.g. {next(iter(rated))}, and none of the {len(sources)} "
                "here; run from the folder in which the page was made, or give its files"
            )
        return {
            source: ": ".join(filter(None, ("rated fail", row.get("comment"))))
            for source, row in found.items()
            if row["rating"] == _FAIL
        }
