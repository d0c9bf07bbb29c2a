"""A table of variables of the members, and what depends on each of them, in files."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...draw.palette import round_up, sizes
from ...draw.plot import both_sides, pose
from ...errors import MeshError
from ...io import npz
from ...io.files import write_mesh
from ...io.reading import reading
from ...io.replacing import replacing
from ...io.tables import SEPARATORS, read_cells
from ...io.textured import write_picture
from .group import Group
from .permutation import LEVEL, PointTest

_SIZE = 480  # pixels of a view: two fill half the width of a screen
_PALE = 0.25  # share of colour that is left where chance explains an effect: enough to see the surface's shape


def read_design(path: str | os.PathLike[str], members: Sequence[str]) -> dict[str, NDArray[np.generic]]:
    """The columns of a .tsv or .csv table by name, numbers or names, rows in the order of the members.

    Its first column names the members: their files, or these without folder and suffix.
    """
    with reading(Path(path)):
        if Path(path).suffix.lower() not in SEPARATORS:
            raise MeshError("a table of variables is a .tsv or .csv file; give one of these")
        header, *rows = read_cells(Path(path))
        known = {row[0]: row for row in rows}
        lines = [known.get(name) or known.get(Path(name).stem) for name in members]
        missing = [name for name, line in zip(members, lines, strict=True) if line is None or len(line) != len(header)]
        if missing:
            raise MeshError(f"the table has no whole row for {len(missing)} members, e.g. {missing[0]}; its first "
                            "column names them")
        if len(header) < 2:
            raise MeshError("the table has one column; give a variable beside the members' names")
        columns = list(zip(*[line for line in lines if line], strict=True))[1:]
        return {name: _values(cells) for name, cells in zip(header[1:], columns, strict=True)}


def _values(cells: Sequence[str]) -> NDArray[np.generic]:
    try:
        return np.array(cells, dtype=np.float64)
    except ValueError:
        return np.array(cells)


def write_test(place: str, group: Group, found: PointTest) -> None:
    """Write arrays (.npz), the mean surface with effects and p at the vertices (.ply), and a picture (.png)."""
    lengths = np.linalg.norm(found.effect, axis=2).max(axis=0)
    with replacing(f"{place}.npz", force=True) as partial:
        npz.write_arrays(partial, {**vars(found), "levels": np.array(found.levels, dtype=str)})
    write_mesh(f"{place}.ply", group.vertices, group.faces, force=True, metadata={"vertex_properties": {
        "effect": lengths, "error": found.error.max(axis=0), "p": found.p, "explained": found.explained}})
    ramp = sizes("effect", round_up(float(lengths.max())))
    colours = ramp.colours(lengths[group.faces].mean(axis=1))
    sure = (found.p[group.faces] <= LEVEL).all(axis=1)
    colours[~sure] = 1 - _PALE + _PALE * colours[~sure]
    picture = both_sides([group.vertices], group.faces, colours, pose(group.vertices).T, _SIZE)
    write_picture(f"{place}.png", picture, force=True)
