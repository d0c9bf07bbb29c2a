"""Findings on a map: sentences for people, the same in shell, notebooks and windows, and numbers for programs."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from typing import Any, NamedTuple

from ..mesh.arrays import BoolArray, FloatArray, plural
from ..verify.certificate import Certificate
from ..verify.distortion import angle_figures, log_figures


class Finding(NamedTuple):
    """A sentence, with the label before it, and the numbers behind it by their names in JSON."""

    label: str
    text: str
    numbers: dict[str, Any]


def as_factor(log: float) -> str:
    """A factor by its natural logarithm, which float64 may not hold.

    >>> as_factor(math.log(20)), as_factor(800.0)
    ('20', 'e^800')
    """
    if log > math.log(sys.float_info.max):
        return f"e^{log:.3g}"
    return f"{math.exp(log):.3g}"


def moved_for_float32(moved: int) -> str:
    """The number of vertices that a file's float32 has moved."""
    return f"{plural(moved, 'vertex', 'vertices')} moved to keep float32 from folding"


def verdict(certificate: Certificate, caps: BoolArray | None = None) -> Finding:
    """Whether the map is free of foldings, and the number of caps."""
    numbers, text = certificate_numbers(certificate), str(certificate)
    if caps is not None:
        numbers["caps"] = int(caps.sum())
        text += (
            f"; {numbers['caps']:,} of its {len(caps):,} faces are caps, which figures leave out"
        )
    return Finding("certificate", text, {"certificate": numbers})


def certificate_numbers(certificate: Certificate, most: int = 10) -> dict[str, Any]:
    """Counts, and the first faces or vertices of each fault, `most` of each."""
    numbers: dict[str, Any] = {
        "folding_free": certificate.folding_free,
        "degree": certificate.degree,
        "orientation": certificate.orientation,
    }
    names = ["flipped", "degenerate", "not_finite", "off_sphere"]
    if certificate.boundary_loops:
        names.append("crossings")
    for name in names:
        where: Sequence[int] = getattr(certificate, name)
        numbers[name] = {"count": len(where), "first": [int(i) for i in where[:most]]}
    return numbers


def energy(value: float) -> Finding:
    """The harmonic energy, eq. (6).

    >>> energy(12.6).text
    '12.600000, which is 4 pi +3.36e-02 (4 pi: a smooth conformal map)'
    >>> energy(-1e-17).text
    '0, next to nothing: the map has collapsed, nearly all of it lies in one point'
    """
    text = f"{value:.6f}, which is 4 pi {value - 4 * math.pi:+.2e} (4 pi: a smooth conformal map)"
    if value < 0.01 * (4 * math.pi):  # a map that covers the sphere has at least its area
        text = f"{max(value, 0):.3g}, next to nothing: the map has collapsed, nearly all of it lies in one point"
    return Finding("energy", text, {"energy": value})


def angles(differences: FloatArray) -> Finding:
    """Angle differences (m, 3) in degrees."""
    numbers = angle_figures(differences)
    text = (
        "differ by {mean:.3g} degrees on average (median {median:.3g}, 95% below {p95:.3g}, 99% below {p99:.3g}, "
        "at most {max:.3g})"
    )
    return Finding("angles", text.format(**numbers), {"angle_differences": numbers})


def areas(logarithms: FloatArray) -> Finding:
    """Logarithms of image area over source area (m,)."""
    return _ratios("areas", "log_area_ratios", logarithms)


def edges(logarithms: FloatArray) -> Finding:
    """Logarithms of image length over source length."""
    return _ratios("edges", "log_length_ratios", logarithms)


def _ratios(label: str, name: str, logarithms: FloatArray) -> Finding:
    numbers = log_figures(logarithms)
    mean, p99, most = (as_factor(numbers[key]) for key in ("mean", "p99", "max"))
    text = f"change {mean}-fold on average, up or down (geometric mean; 99% below {p99}, at most {most})"
    return Finding(label, text, {name: numbers})
