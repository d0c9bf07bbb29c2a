"""`check` and `repair`: certify maps of any program, and free them of foldings."""

from argparse import Namespace
from dataclasses import replace

import numpy as np

from ....descent.energies import HarmonicEnergy
from ....io.written_map import SphereCheck, certify_radius
from ....maps.given_sphere import repair_foldings
from ....mesh.arrays import EPS, FloatArray, check_directions
from ....mesh.check import Mesh, check_mesh
from ....result import findings
from ....result.findings import Finding
from ....sphere.rows import row_lengths, unit_rows
from ....verify.certificate import Certificate
from ....verify.distortion import angle_differences, log_area_ratios, log_length_ratios
from ..arguments import refuse_flags
from ..exits import Exit
from ..inputs import InputMap, load_pair
from ..output import Findings, check_outputs, mirrored, write_sphere
from .plane import check_plane_map, load_map


def run_check(args: Namespace) -> Exit:
    check_outputs(args)
    pair = load_map(args, args.reflect)
    if not isinstance(pair, InputMap):
        refuse_flags(args, ("--directions", "--reflect"), "a map to the plane")
        return check_plane_map(args, *pair)
    mesh = check_mesh(pair.source.v, pair.source.f, caps=pair.source.caps)
    args.progress.begin(f"certifying {pair.name}")
    x = pair.x
    if args.directions:
        x = unit_rows(check_directions(x, name=f"{pair.name}: images"))
    checked = certify_radius(x, mesh.f)
    off_radius = _off_radius(x, checked)
    certificate: Certificate = checked
    # with one digit a cube would pass for a sphere
    rounded = bool(off_radius) and _farthest(off_radius) <= off_radius["rounding"] <= 1e-3
    if rounded:  # exact signs are those of directions, at any distance of the vertices
        certificate = replace(checked, off_sphere=checked.off_sphere[:0])
    found = Findings()
    label, text, numbers = findings.verdict(certificate, mesh.caps)
    if rounded:
        kind = "certified"
        if not certificate.folding_free:
            kind = "not certified, even"
        text = (
            f"{kind} once scaled to the sphere; radii vary by {off_radius['highest'] - off_radius['lowest']:.1g}, "
            f"as the file's numbers are rounded; {text}"
        )
    found.add(label, text, **numbers)
    found.source(pair.source)
    found.add(
        "sphere",
        f"{pair.name}{mirrored(args)}: radius {checked.radius:.6g}",
        sphere=pair.name,
        radius=checked.radius,
        reflect=args.reflect,
        directions=args.directions,
    )
    if off_radius:
        text = (
            f"{len(checked.off_sphere)} vertices are off by {off_radius['lowest']:+.2g} to "
            f"{off_radius['highest']:+.2g} of the radius, most at vertex {off_radius['farthest']}"
        )
        if not rounded:
            text += (
                "; --directions certifies where they point to, and the command repair moves them onto "
                "the sphere"
            )
        found.add("off radius", text, off_radius=off_radius)
    if not len(checked.not_finite) and checked.radius > 0:
        found.extend(_measured(mesh, x / checked.radius))
    return found.report(args, certificate)


def _off_radius(x: FloatArray, checked: SphereCheck) -> dict[str, float]:
    """The vertices' distance off the sphere, in radii, and that by rounding; empty if none is off."""
    off = checked.off_sphere
    if not len(off) or checked.radius <= 0:
        return {}
    beyond = row_lengths(x[off]) / checked.radius - 1
    return {
        "lowest": beyond.min(),
        "highest": beyond.max(),
        "farthest": int(off[np.abs(beyond).argmax()]),
        "rounding": _rounding(x) / checked.radius,
    }


def _farthest(off_radius: dict[str, float]) -> float:
    return max(-off_radius["lowest"], off_radius["highest"])


def _measured(mesh: Mesh, x: FloatArray) -> list[Finding]:
    """Energy, angles, areas and edges of a map of unit rows."""
    v, surface = mesh.v, mesh.f[mesh.surface]
    return [
        findings.energy(HarmonicEnergy.of(mesh).evaluate(x)[0]),
        findings.angles(angle_differences(v, surface, x)),
        findings.areas(log_area_ratios(v, surface, x)),
        findings.edges(log_length_ratios(v, surface, x)),
    ]


def _rounding(x: FloatArray, digits: int = 7) -> float:
    """Bound the movement of a row by the rounding of its numbers, to float32 or to their decimals.

    Digits are tried as far as float32 holds them.
    """
    size, epsilon, step = float(np.abs(x).max()), EPS, 0.0
    if (x == x.astype(np.float32)).all():
        epsilon = float(np.finfo(np.float32).eps)
        step = epsilon * size
    for decimals in range(digits - int(np.floor(np.log10(size)))):
        if (np.abs(x - np.round(x, decimals)) <= epsilon * size).all():
            return max(step, 10.0**-decimals) * np.sqrt(3) / 2
    return step * np.sqrt(3) / 2


def run_repair(args: Namespace) -> Exit:
    check_outputs(args, surface=True)
    pair = load_pair(args)
    source, x = pair.source, pair.x
    before = certify_radius(x, source.f)
    args.progress.begin(f"repairing {pair.name}")
    result = repair_foldings(
        source.v, source.f, x, caps=source.caps, listener=args.progress.listener(source.f)
    )
    written = write_sphere(args, result, source, radius=before.radius)
    unit = unit_rows(x.astype(np.float64))
    found = Findings(sphere=pair.name, target=args.target)
    found.source(source)
    for label, file, positions, certificate in (
        ("before", pair.name, unit, before),
        ("after", args.target, result.sphere, written),
    ):
        found.add(label, f"{file}: {certificate}")
        angles = findings.angles(
            angle_differences(result.vertices, result.faces[result.mesh.surface], positions)
        )
        found.add(angles.label, angles.text)
        found.figures[label] = findings.verdict(certificate, source.caps).numbers | angles.numbers
    # directions that differ by less are unmoved
    moved = int((np.linalg.norm(unit_rows(result.sphere) - unit, axis=1) > 1e-14).sum())
    found.add(
        "moved", f"{moved} vertices, in {result.seconds:.2f} s", moved=moved, seconds=result.seconds
    )
    found.notes(result.notes)
    return found.report(args, written)
