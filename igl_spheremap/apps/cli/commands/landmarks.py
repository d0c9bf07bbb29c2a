"""Map harmonically with landmarks moved towards targets.

    igl-spheremap landmarks lh.pial lh.sphere.conformal --points landmarks.txt --weight 100
"""

from __future__ import annotations

from argparse import Namespace

import numpy as np

from ....errors import FileError
from ....io.reading import read_lines
from ....maps.landmarks import landmark_map
from ....mesh.arrays import FloatArray, IntArray
from ....sphere.rows import unit_rows
from ..chosen import given
from ..exits import Exit
from ..mapping import map_by
from ..output import Findings

_SHOWN = 20  # landmarks that the summary lists


def run(args: Namespace) -> Exit:
    """Map with landmarks."""
    vertices, targets, weights = read_points(args.points, args.weight)
    options = given(args, "tolerance", "max_iterations") | {"keep_injective": not args.may_fold}
    return map_by(
        args,
        lambda v, f, listener: landmark_map(v, f, vertices, targets, weights, listener=listener, **options),
        lambda found, result: _misses(found, result.sphere[vertices], targets, vertices),
    )


def _misses(found: Findings, x: FloatArray, targets: FloatArray, vertices: IntArray) -> None:
    """Degrees between landmarks (k, 3) and their targets, in the order of the file."""
    misses = np.degrees(2 * np.arcsin(np.minimum(np.linalg.norm(x - unit_rows(targets), axis=1) / 2, 1)))
    for k, miss in zip(vertices[:_SHOWN], misses, strict=False):
        found.add(f"vertex {k}", f"misses its target by {miss:.3g} degrees")
    more = f", and {len(misses) - _SHOWN} more that --json lists" if len(misses) > _SHOWN else ""
    found.add("landmarks", f"miss by {misses.mean():.3g} degrees on average, at most {misses.max():.3g}{more}",
              landmarks=[{"vertex": k, "miss": miss} for k, miss in zip(vertices, misses, strict=True)])


def read_points(path: str, weight: float) -> tuple[IntArray, FloatArray, FloatArray]:
    """Vertices (k,), targets (k, 3) and weights (k,) from lines of four or five numbers; # begins a comment.

    `weight` is that of lines with four numbers; a FileError names a line that is something else.
    """
    rows = []
    for number, line in enumerate(read_lines(path), 1):
        words = line.partition("#")[0].replace(",", " ").split()
        if not words:
            continue
        try:
            row = [int(words[0]), *map(float, words[1:])]
        except ValueError:
            row = []
        if len(row) not in (4, 5):
            raise FileError(f"{path}, line {number}: give a vertex, three coordinates, and optionally a weight")
        rows.append([*row, weight][:5])
    if not rows:
        raise FileError(f"{path} has no landmarks")
    table = np.array(rows)
    return table[:, 0].astype(np.int64), table[:, 1:4], table[:, 4]
