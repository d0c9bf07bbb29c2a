"""`igl-spheremap check SOURCE SPHERE`: certify a map from any program."""

from __future__ import annotations

from argparse import Namespace
from typing import Any

from ....descent.energies.harmonic import harmonic_energy
from ....io import certify_radius
from ....verify.distortion import angle_differences
from ....verify.figures import angle_figures, log_figures
from ....verify.stretch import area_distortion, edge_distortion
from ..exits import Exit
from ..output import angle_row, certificate_figures, energy_row, log_row, mesh_row, report, row
from ..pair import load_pair
from ..streams import check_outputs


def run(args: Namespace) -> Exit:
    """Certify and measure."""
    check_outputs(args)
    source, name, x = load_pair(args)
    args.progress.stage(f"certifying {name}")
    found = certify_radius(x, source.f)
    figures: dict[str, Any] = {
        "source": source.name,
        "repairs": source.repairs,
        "sphere": name,
        "vertices": len(x),
        "faces": len(source.f),
        "radius": found.radius,
        "certificate": certificate_figures(found.certificate),
    }
    summary = [
        mesh_row("source", source.name, len(x), len(source.f)),
        row("sphere", f"{name}: radius {found.radius:.6g}"),
    ]
    if not len(found.certificate.not_finite) and found.radius > 0:
        unit = x / found.radius
        figures["energy"] = harmonic_energy(source.v, source.f, unit)
        figures["angle_differences"] = angle_figures(angle_differences(source.v, source.f, unit))
        figures["area_ratios"] = log_figures(area_distortion(source.v, source.f, unit))
        figures["edge_ratios"] = log_figures(edge_distortion(source.v, source.f, unit))
        summary += [energy_row(figures["energy"]), angle_row(figures["angle_differences"]),
                    log_row("areas", figures["area_ratios"]), log_row("edges", figures["edge_ratios"])]
    report(args, figures, [*summary, row("certificate", str(found.certificate))])
    return Exit.OK if found.certificate.folding_free else Exit.FOLDINGS
