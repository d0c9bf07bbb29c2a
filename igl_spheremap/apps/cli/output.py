"""Figures of a run: a summary in 80 columns for people, JSON for programs."""

from __future__ import annotations

import json
import math
import sys
import textwrap
from argparse import Namespace
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...io.replacing import replacing
from ...mesh.arrays import FloatArray, IntArray
from ...verify.certificate import Certificate
from ...verify.distortion import angle_figures, describe_angles, describe_logs, log_figures
from .source import Source
from .streams import STREAM

WIDTH = 80
_LABEL = 13
_SHOWN = 10  # faces or vertices that JSON lists of each kind of fault


class Findings:
    """What a command found: figures for programs, and the lines of a summary for people."""

    def __init__(self, **figures: Any) -> None:
        self.figures = figures
        self.lines: list[str] = []

    def add(self, label: str, text: str, **figures: Any) -> None:
        """Add a labelled paragraph, and the figures that it states."""
        self.lines.append(row(label, text))
        self.figures |= figures

    def mesh(self, label: str, source: Source) -> None:
        """Add the name and the size of a mesh."""
        self.add(label, mesh_size(source.name, source.v, source.f), **{label: source.name})

    def source(self, source: Source) -> None:
        """Add the mesh that the command read."""
        self.mesh("source", source)
        self.figures |= {"repairs": source.repairs, "vertices": len(source.v), "faces": len(source.f)}

    def energy(self, energy: float) -> None:
        """Add the harmonic energy, eq. (6)."""
        above = f"4 pi {energy - 4 * math.pi:+.2e} (4 pi: a smooth conformal map)"
        self.add("energy", f"{energy:.6f}, which is {above}", energy=energy)

    def angles(self, differences: FloatArray) -> None:
        """Add angle differences (m, 3) in degrees."""
        figures = angle_figures(differences)
        self.add("angles", f"differ by {describe_angles(figures)}", angle_differences=figures)

    def ratios(self, kind: str, logarithms: FloatArray) -> None:
        """Add logarithms of the ratios of areas or edges."""
        figures = log_figures(logarithms)
        self.add(f"{kind}s", f"log(image / source) is {describe_logs(figures)}", **{f"{kind}_ratios": figures})

    def certificate(self, certificate: Certificate) -> None:
        """Add a certificate."""
        self.add("certificate", str(certificate), certificate=certificate_figures(certificate))

    def report(self, args: Namespace) -> None:
        """Print the summary and write the JSON, as the flags ask."""
        args.progress.close()
        if args.json is not None:
            text = json.dumps(_plain(self.figures), indent=2, allow_nan=False) + "\n"
            if args.json == STREAM:
                sys.stdout.write(text)
                return
            with replacing(args.json, force=True) as partial:
                partial.write_text(text)
        if not args.quiet:
            surface_on_stdout = getattr(args, "target", None) == STREAM
            print(*self.lines, sep="\n", file=sys.stderr if surface_on_stdout else sys.stdout, flush=True)


def row(label: str, text: str) -> str:
    """A labelled paragraph of the summary, wrapped behind a label of at most 12 characters.

    >>> row("energy", "12.57")
    'energy       12.57'
    """
    return textwrap.fill(
        text,
        WIDTH,
        initial_indent=label.ljust(_LABEL),
        subsequent_indent=" " * _LABEL,
        break_long_words=False,
        break_on_hyphens=False,
    )


def mesh_size(name: str, v: FloatArray, f: IntArray) -> str:
    """A mesh's name and size."""
    return f"{name}: {len(v)} vertices, {len(f)} faces"


def certificate_figures(certificate: Certificate) -> dict[str, Any]:
    """A certificate for JSON: counts, and the first faces or vertices of each fault."""
    figures: dict[str, Any] = {"folding_free": certificate.folding_free, "degree": certificate.degree}
    for name in ("flipped", "degenerate", "not_finite", "off_sphere"):
        where: Sequence[int] = getattr(certificate, name)
        figures[name] = {"count": len(where), "first": [int(i) for i in where[:_SHOWN]]}
    return figures


def _plain(value: Any) -> Any:
    """Only numbers, strings, lists and dicts; what is not finite becomes null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.generic | np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int | str) else str(value)
