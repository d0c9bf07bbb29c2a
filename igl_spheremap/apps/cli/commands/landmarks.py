"""`igl-spheremap landmarks IN OUT --points FILE`: map harmonically with landmarks drawn towards targets."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

import numpy as np
from numpy.typing import NDArray

from ....errors import FileError
from ....io.reading import read_lines
from ....maps.landmarks import landmark_map
from ..exits import Exit
from ..failures import UsageError
from ..mapping import add_map_arguments, add_may_fold, map_by


def configure(parser: ArgumentParser) -> None:
    """Add the arguments."""
    add_map_arguments(parser)
    parser.add_argument(
        "--points",
        metavar="FILE",
        required=True,
        help="one landmark a line: vertex (from 0), then x y z of its target on the sphere, and a weight if it "
        "is not --weight",
    )
    parser.add_argument(
        "--weight", type=float, metavar="W", default=100.0, help="of squared distances to targets (default: 100)"
    )
    add_may_fold(parser)


def run(args: Namespace) -> Exit:
    """Map with landmarks."""
    if not 0 <= args.weight < float("inf"):
        raise UsageError(f"--weight {args.weight:g} is out of range: give a number from 0")
    vertices, targets, weights = read_points(args.points, args.weight)
    injective = not args.may_fold
    return map_by(
        args,
        lambda v, f, **options: landmark_map(v, f, vertices, targets, weights, keep_injective=injective, **options),
    )


def read_points(path: str, weight: float) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
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
