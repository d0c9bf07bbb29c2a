"""Certify a map to the sphere, from any program.

    igl-spheremap check lh.pial lh.sphere.conformal
    igl-spheremap check bunny.obj their_sphere.ply --json -
    igl-spheremap check bunny_map.npz
"""

from __future__ import annotations

from argparse import Namespace

from ....descent.energies.harmonic import harmonic_energy
from ....io import certify_radius
from ....verify.distortion import angle_differences, area_distortion, edge_distortion
from ..exits import Exit
from ..output import Findings
from ..pair import load_pair
from ..streams import check_outputs


def run(args: Namespace) -> Exit:
    """Certify and measure."""
    check_outputs(args)
    pair = load_pair(args)
    v, f = pair.source.v, pair.source.f
    args.progress.stage(f"certifying {pair.name}")
    checked = certify_radius(pair.x, f)
    found = Findings()
    found.source(pair.source)
    found.add("sphere", f"{pair.name}: radius {checked.radius:.6g}", sphere=pair.name, radius=checked.radius)
    if not len(checked.certificate.not_finite) and checked.radius > 0:
        unit = pair.x / checked.radius
        found.energy(harmonic_energy(v, f, unit))
        found.angles(angle_differences(v, f, unit))
        found.ratios("area", area_distortion(v, f, unit))
        found.ratios("edge", edge_distortion(v, f, unit))
    found.certificate(checked.certificate)
    found.report(args)
    return Exit.OK if checked.certificate.folding_free else Exit.UNCERTIFIED
