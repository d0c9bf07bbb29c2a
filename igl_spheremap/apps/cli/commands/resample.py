"""`igl-spheremap resample IN SPHERE OUT`: a surface with the connectivity of a regular sphere, or of another map."""

from __future__ import annotations

from argparse import Namespace
from typing import Any

import numpy as np

from ....io import write_mesh
from ....shapes.locate import SphereLocator
from ....shapes.transfer import interpolate
from ..output import mesh_row, report, row
from ..pair import load_pair
from ..streams import check_outputs, target_format, write_target
from ..target_sphere import read_target_sphere


def run(args: Namespace) -> None:
    """Locate the new vertices on the map, and interpolate; a map that folds is an error, Exit.FOLDINGS."""
    check_outputs(args, surface=True)
    points, faces = read_target_sphere(args)
    source, name, x = load_pair(args)
    args.progress.stage(f"resampling {source.name}")
    locator = SphereLocator(x / np.median(np.linalg.norm(x, axis=1)), source.f)
    v = interpolate(source.v, source.f, locator.locate(points))
    write_target(args, lambda path: write_mesh(path, v, faces, force=args.force, metadata=source.metadata))
    figures: dict[str, Any] = {
        "source": source.name,
        "sphere": name,
        "to": args.to,
        "target": args.target,
        "vertices": len(v),
        "faces": len(faces),
    }
    summary = [
        mesh_row("source", source.name, len(source.v), len(source.f)),
        row("sphere", f"{name}, resampled at the vertices of {args.to}"),
        mesh_row("written", f"{args.target} ({target_format(args).name})", len(v), len(faces)),
    ]
    report(args, figures, summary)
