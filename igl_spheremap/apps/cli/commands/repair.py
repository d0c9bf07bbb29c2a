"""Remove the foldings of a map, from any program.

    igl-spheremap repair lh.pial their.sphere repaired.sphere
"""

from __future__ import annotations

from argparse import Namespace

import numpy as np

from ....io import certify_radius, write_map
from ....maps.repair_foldings import repair_foldings
from ....sphere.rows import unit_rows
from ....verify.distortion import angle_differences
from ..exits import Exit
from ..output import Findings, certificate_figures
from ..pair import load_pair
from ..streams import check_outputs, write_target

_ROUNDING = 1e-14  # directions that differ by less count as unmoved


def run(args: Namespace) -> Exit:
    """Repair, write, and certify what was written."""
    check_outputs(args, surface=True)
    pair = load_pair(args)
    source, x = pair.source, pair.x
    before = certify_radius(x, source.f)
    args.progress.stage(f"repairing {pair.name}")
    result = repair_foldings(source.v, source.f, x, listener=args.progress.listener(source.f))
    written = write_target(
        args,
        lambda path: write_map(path, result, force=args.force, radius=before.radius, metadata=source.metadata),
    )
    unit = unit_rows(x.astype(np.float64))
    found = Findings(sphere=pair.name, target=args.target)
    found.source(source)
    for label, file, positions, certificate in (
        ("before", pair.name, unit, before.certificate),
        ("after", args.target, result.sphere, written.certificate),
    ):
        found.add(label, f"{file}: {certificate}")
        found.angles(angle_differences(source.v, source.f, positions))
        angles = found.figures.pop("angle_differences")
        found.figures[label] = {"certificate": certificate_figures(certificate), "angle_differences": angles}
    moved = int((np.linalg.norm(unit_rows(result.sphere) - unit, axis=1) > _ROUNDING).sum())
    found.add("moved", f"{moved} vertices, in {result.seconds:.2f} s", moved=moved, seconds=result.seconds)
    found.report(args)
    return Exit.OK if written.certificate.folding_free else Exit.UNCERTIFIED
