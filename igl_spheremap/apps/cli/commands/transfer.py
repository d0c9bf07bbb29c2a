"""`igl-spheremap transfer SOURCE SPHERE OUT --data FILE`: carry data to another mapped surface, or to an icosphere."""

from __future__ import annotations

from argparse import Namespace

import numpy as np

from ....io import write_scalars
from ....shapes.locate import SphereLocator
from ....shapes.transfer import interpolate
from ..output import mesh_row, report, row
from ..pair import load_pair
from ..streams import check_outputs
from ..target_sphere import read_target_sphere
from ..vertex_data import read_maps


def run(args: Namespace) -> None:
    """Locate the target's vertices on the source's map, and interpolate; the two maps must share a frame."""
    check_outputs(args)
    points, _ = read_target_sphere(args)
    source, name, x = load_pair(args)
    maps = read_maps(args.data, len(source.v), source.name)
    args.progress.stage(f"locating {len(points)} points on {name}")
    location = SphereLocator(x / np.median(np.linalg.norm(x, axis=1)), source.f).locate(points)
    carried = {key: interpolate(values, source.f, location, args.labels) for key, values in maps.items()}
    write_scalars(args.target, carried, force=args.force, metadata=source.metadata)
    ranges = {key: [float(values.min()), float(values.max())] for key, values in carried.items()}
    figures = {"source": source.name, "sphere": name, "to": args.to, "target": args.target, "vertices": len(points),
               "maps": ranges}  # fmt: skip
    summary = [
        mesh_row("source", source.name, len(source.v), len(source.f)),
        row("sphere", f"{name}, at the {len(points)} vertices of {args.to}"),
        *(row("written", f"{args.target}: {key}, {low:.4g} to {high:.4g}") for key, (low, high) in ranges.items()),
    ]
    report(args, figures, summary)
