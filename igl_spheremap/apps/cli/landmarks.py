"""`igl-spheremap landmarks IN OUT --points FILE`: map harmonically so that landmarks go where they ought to."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...errors import FileError
from ...maps.variational import landmark_map
from .command import Command, UsageError
from .exits import Exit
from .map_command import add_map_arguments, map_by


def configure(parser: ArgumentParser) -> None:
    """Add the arguments of `landmarks`.

    Parameters
    ----------
    parser : ArgumentParser
        Gains them.

    Returns
    -------
    None
    """
    add_map_arguments(parser)
    parser.add_argument(
        "--points",
        metavar="FILE",
        required=True,
        help="one landmark a line: vertex (from 0), then x y z of its target on the sphere, and a weight if it "
        "is not --weight",
    )
    parser.add_argument("--weight", type=float, metavar="W", default=100.0, help="of squared misses (default: 100)")
    parser.add_argument("--may-fold", action="store_true", help="take steps that fold, too")


def run(args: Namespace) -> Exit:
    """Map, write, certify what was written, and tell.

    Parameters
    ----------
    args : Namespace
        As configured.

    Returns
    -------
    Exit
        OK only with the certificate of the numbers in the file.
    """
    if not 0 <= args.weight < float("inf"):
        raise UsageError(f"--weight {args.weight:g} is out of range: give a number from 0")
    vertices, targets, weights = read_points(args.points, args.weight)
    confine = not args.may_fold
    return map_by(
        args,
        lambda v, f, **options: landmark_map(v, f, vertices, targets, weights, confine=confine, **options),
    )


def read_points(path: str, weight: float) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Landmarks from a text file.

    Parameters
    ----------
    path : str
        Lines of four or five numbers, parted by blanks or commas; what follows a # is left out.
    weight : float
        Of landmarks that have none of their own.

    Returns
    -------
    vertices : (k,) int64 array
    targets : (k, 3) float64 array
    weights : (k,) float64 array

    Raises
    ------
    FileError
        If the file can't be read, or a line is something else.
    """
    try:
        lines = Path(path).read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(f"can't read {path}: {getattr(error, 'strerror', None) or error}") from error
    rows = []
    for number, line in enumerate(lines, 1):
        words = line.partition("#")[0].replace(",", " ").split()
        if not words:
            continue
        try:
            row = [int(words[0]), *map(float, words[1:])]
        except ValueError:
            row = []
        if len(row) not in (4, 5):
            raise FileError(f"{path}, line {number}: give a vertex, three coordinates, and perhaps a weight")
        rows.append([*row, weight][:5])
    if not rows:
        raise FileError(f"{path} has no landmarks")
    table = np.array(rows)
    return table[:, 0].astype(np.int64), table[:, 1:4], table[:, 4]


COMMAND = Command(
    "landmarks",
    "map harmonically so that landmarks come to lie where they ought to",
    """\
igl-spheremap landmarks lh.pial lh.sphere --points landmarks.txt --weight 100""",
    configure,
    run,
)
