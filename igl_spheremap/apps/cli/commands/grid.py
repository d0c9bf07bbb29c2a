"""Sample a mapped surface, or data over it, on latitudes and longitudes.

    igl-spheremap grid bunny.ply bunny_sphere.ply bunny_positions.npz --kind gauss --rows 64
    igl-spheremap grid lh.pial lh.sphere.conformal lh_sulc.png --data lh.sulc
"""

from __future__ import annotations

from argparse import Namespace

import numpy as np
from numpy.typing import NDArray

from ....draw.palette import colours
from ....errors import import_optional
from ....io import write_picture
from ....io.npz import write_arrays
from ....io.replacing import replacing
from ....mesh.arrays import FloatArray
from ....shapes.grid import to_grid
from ..failures import UsageError
from ..output import Findings
from ..pair import load_pair
from ..streams import check_outputs
from ..vertex_data import read_data


def run(args: Namespace) -> None:
    """Sample, write, and report."""
    target: str = args.target
    if not target.lower().endswith((".png", ".npz")):
        raise UsageError(f"OUT is a .png or .npz file, not {target}")
    check_outputs(args)
    if target.lower().endswith(".png"):
        import_optional("PIL.Image", "a picture", "io")
    pair = load_pair(args)
    source = pair.source
    values = source.v if args.data is None else read_data(args.data, len(source.v), source.name)
    args.progress.stage(f"sampling {source.name}")
    grid = to_grid(pair.map(), values, args.kind, args.rows)
    if target.lower().endswith(".png"):
        write_picture(target, _picture(grid), force=args.force)
    else:
        with replacing(target, args.force) as partial:
            write_arrays(partial, {"grid": grid, "kind": args.kind})
    found = Findings(source=source.name, sphere=pair.name, target=target, kind=args.kind, shape=grid.shape)
    found.add("written", f"{target}: {args.kind}, {grid.shape[0]} x {grid.shape[1]}")
    found.report(args)


def _picture(grid: FloatArray) -> NDArray[np.uint8]:
    """One column by the colour scale, three as red, green and blue on a common scale."""
    columns = grid.shape[2]
    if columns == 1:
        shades = colours(grid.ravel())
        return np.stack([shades[name] for name in ("red", "green", "blue")], axis=1).reshape(*grid.shape[:2], 3)
    if columns != 3:
        raise UsageError(f"a picture shows one or three columns, not {columns}: choose one by --data FILE:NAME")
    low = grid.min(axis=(0, 1))
    return np.round((grid - low) * (255 / (np.ptp(grid, axis=(0, 1)).max() or 1.0))).astype(np.uint8)
