"""`igl-spheremap check SOURCE SPHERE`: certify a map from whatever program."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...descent.problem import harmonic_energy
from ...io import SphereCheck, certify_radius
from ...verify.distortion import angle_differences
from ...verify.figures import angle_figures
from .command import Command
from .exits import Exit
from .output import add_output, angle_row, certificate_figures, check_json, energy_row, put_out, row
from .pair import add_pair, load_pair
from .source import Source


def configure(parser: ArgumentParser) -> None:
    """Add the arguments of `check`.

    Parameters
    ----------
    parser : ArgumentParser
        Gains them.

    Returns
    -------
    None
    """
    add_pair(parser, "SOURCE", optional=True)
    add_output(parser)


def run(args: Namespace) -> Exit:
    """Certify, measure, and tell.

    Parameters
    ----------
    args : Namespace
        As configured.

    Returns
    -------
    Exit
        OK only with the certificate.
    """
    check_json(args)
    source, name, x = load_pair(args)
    found = certify_radius(x, source.f)
    figures, summary = _tell(source, name, x, found)
    put_out(args, figures, summary)
    return Exit.OK if found.certificate.folding_free else Exit.FOLDINGS


def _tell(
    source: Source, name: str, x: NDArray[np.float64], found: SphereCheck
) -> tuple[dict[str, Any], str]:
    figures: dict[str, Any] = {
        "source": source.name,
        "repairs": source.repairs,
        "sphere": name,
        "vertices": len(x),
        "faces": len(source.f),
        "radius": found.radius,
        "certificate": certificate_figures(found.certificate),
    }
    lines = [
        row("source", f"{source.name}: {len(x)} vertices, {len(source.f)} faces"),
        row("sphere", f"{name}: radius {found.radius:.6g}"),
    ]
    if not len(found.certificate.not_finite) and found.radius > 0:
        unit = x / found.radius
        figures["energy"] = harmonic_energy(source.v, source.f, unit)
        figures["angle_differences"] = angle_figures(angle_differences(source.v, source.f, unit))
        lines += [energy_row(figures["energy"]), angle_row(figures["angle_differences"])]
    lines.append(row("certificate", str(found.certificate)))
    return figures, "\n".join(lines)


COMMAND = Command(
    "check",
    "certify a map to the sphere, from whatever program it comes",
    """\
igl-spheremap check lh.pial lh.sphere
igl-spheremap check bunny.obj their_sphere.ply --json -
igl-spheremap check bunny_map.npz""",
    configure,
    run,
)
