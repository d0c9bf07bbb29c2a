"""A table of variables of the members, and tests of each, in files."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import MeshError
from ...gate import PathLike
from ...io import npz
from ...io.reading import reading
from ...io.tables import SEPARATORS, read_cells
from ...io.write_mesh import write_mesh
from ...mesh.arrays import FloatArray
from .files import distinct
from .group import Group
from .permutation import PointTest, is_missing, level


def data_of(group: Group, name: str) -> FloatArray:
    """Tested data of a group (members, n, d): its shapes, its scores, or a feature by its name."""
    known = {"shapes": group.shapes, "scores": group.scores[:, :, None]}
    known |= {feature: group.features[:, :, [k]] for k, feature in enumerate(group.feature_names)}
    if name not in known:
        raise MeshError(f"the group has no {name}; test {', '.join(known)}")
    return known[name]


class Design(NamedTuple):
    """Variables by name, as numbers or words, of the members that have all; of each other member, the missing ones."""

    columns: dict[str, NDArray[np.generic]]
    members: list[int]
    left_out: dict[str, str]


def read_design(path: PathLike, members: Sequence[str]) -> Design:
    """The columns of a .tsv or .csv table, rows in the order of the members.

    Its first column names the members: their files, or these without folder and suffix.
    """
    with reading(Path(path)):
        if Path(path).suffix.lower() not in SEPARATORS:
            raise MeshError("a table of variables is a .tsv or .csv file; give one of these")
        header, *rows = [[level(cell) for cell in row] for row in read_cells(Path(path))]
        if len(header) < 2:
            raise MeshError("the table has one column; give a variable beside the members' names")
        if twice := [name for name, count in Counter(header).items() if count > 1]:
            raise MeshError(f"the table has two columns {twice[0]!r}; give each a name of its own")
        cells = np.array([row[1:] for row in _rows_of(members, header, rows)])
        lacking = [
            [name for name, cell in zip(header[1:], row, strict=True) if is_missing(cell)]
            for row in cells
        ]
        kept = [k for k, names in enumerate(lacking) if not names]
        if len(kept) < 3:
            raise MeshError(
                f"{len(kept)} of {len(members)} members have a value in each column, and a test needs "
                "3; take out columns with missing values"
            )
        left_out = {
            members[k]: f"no {' and no '.join(names)}" for k, names in enumerate(lacking) if names
        }
        columns = {
            name: _values(column) for name, column in zip(header[1:], cells[kept].T, strict=True)
        }
        return Design(columns, kept, left_out)


def _rows_of(
    members: Sequence[str], header: Sequence[str], rows: Sequence[list[str]]
) -> Iterator[list[str]]:
    """The row of each member; unless exactly one row without gaps fits it, and fits no other, a MeshError."""
    by_name: dict[str, list[list[str]]] = {}
    for row in rows:
        by_name.setdefault(row[0], []).append(row)
    owners: dict[str, str] = {}
    for member in members:
        fitting = [
            row
            for name in dict.fromkeys((level(member), level(Path(member).stem)))
            for row in by_name.get(name, ())
        ]
        if len(fitting) > 1:
            raise MeshError(f"the table has {len(fitting)} rows for {member}; leave one of them")
        if not fitting or len(fitting[0]) != len(header):
            raise MeshError(
                f"the table has no whole row for {member}; its first column names the members"
            )
        if (owner := owners.setdefault(fitting[0][0], member)) != member:
            raise MeshError(
                f"the row {fitting[0][0]} fits {owner} and {member}; name their files in the table"
            )
        yield fitting[0]


def _values(cells: NDArray[np.str_]) -> NDArray[np.generic]:
    try:
        return cells.astype(np.float64)
    except ValueError:
        return cells


def test_names(variables: Sequence[str]) -> list[str]:
    """Names of the files of each variable's test: letters and numbers of its name; if two agree, a number.

    >>> test_names(["age (y)", "age [y]", "sex"])
    ['test_age__y__1', 'test_age__y__2', 'test_sex']
    """
    # 40 letters of up to 4 bytes each: a name of a file has 255
    return distinct([re.sub(r"\W", "_", f"test_{name[:40]}") for name in variables])


def write_test(stem: str, group: Group, found: PointTest) -> None:
    """Write arrays (.npz), and, for data at the vertices, the mean surface with effects and p (.ply)."""
    texts = {name: np.array(getattr(found, name), dtype=str) for name in ("levels", "notes")}
    npz.save_arrays(f"{stem}.npz", vars(found) | texts)
    if len(found.p) != len(group.vertices):
        return
    lengths = np.linalg.norm(found.effect, axis=2).max(axis=0)
    write_mesh(
        f"{stem}.ply",
        group.vertices,
        group.faces,
        force=True,
        metadata={
            "vertex_properties": {
                "effect": lengths,
                "error": found.error.max(axis=0),
                "p": found.p,
                "explained": found.explained,
            }
        },
    )
