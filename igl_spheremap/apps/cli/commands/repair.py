"""`igl-spheremap repair SOURCE SPHERE OUT`: remove the foldings of a map from any program."""

from __future__ import annotations

from argparse import Namespace
from typing import Any

import numpy as np

from ....io import certify_radius, write_map
from ....maps.repair_foldings import repair_foldings
from ....sphere.rows import unit_rows
from ....verify.distortion import angle_differences
from ....verify.figures import angle_figures
from ..exits import Exit
from ..output import angle_row, certificate_figures, mesh_row, report, row
from ..pair import load_pair
from ..streams import check_outputs, write_target

_ROUNDING = 1e-14  # directions that differ by less count as unmoved


def run(args: Namespace) -> Exit:
    """Repair, write, and certify what was written."""
    check_outputs(args, surface=True)
    source, name, x = load_pair(args)
    before = certify_radius(x, source.f)
    args.progress.stage(f"repairing {name}")
    result = repair_foldings(source.v, source.f, x, listener=args.progress.listener(source.f))
    written = write_target(
        args,
        lambda path: write_map(path, result, force=args.force, radius=before.radius, metadata=source.metadata),
    )
    unit = unit_rows(x.astype(np.float64))
    moved = int((np.linalg.norm(unit_rows(result.sphere) - unit, axis=1) > _ROUNDING).sum())
    stages = [
        ("before", name, unit, before.certificate),
        ("after", args.target, result.sphere, written.certificate),
    ]
    figures: dict[str, Any] = {
        "source": source.name,
        "repairs": source.repairs,
        "sphere": name,
        "target": args.target,
        "vertices": len(x),
        "faces": len(source.f),
        "moved": moved,
        "seconds": result.seconds,
    }
    summary = [mesh_row("source", source.name, len(x), len(source.f))]
    for label, file, positions, certificate in stages:
        angles = angle_figures(angle_differences(source.v, source.f, positions))
        figures[label] = {"certificate": certificate_figures(certificate), "angle_differences": angles}
        summary += [row(label, f"{file}: {certificate}"), angle_row(angles)]
    report(args, figures, [*summary, row("moved", f"{moved} vertices, in {result.seconds:.2f} s")])
    return Exit.OK if written.certificate.folding_free else Exit.FOLDINGS
