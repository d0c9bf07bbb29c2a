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
from ...verify.certificate import Certificate
from .streams import STREAM

WIDTH = 80
_LABEL = 13
_SHOWN = 10  # faces that JSON lists of each kind of fault


def report(args: Namespace, figures: Mapping[str, Any], summary: Sequence[str]) -> None:
    """Print the lines of the summary and write the JSON, as the flags ask."""
    args.progress.close()
    if args.json is not None:
        text = json.dumps(_plain(figures), indent=2, allow_nan=False) + "\n"
        if args.json == STREAM:
            sys.stdout.write(text)
            return
        with replacing(args.json, force=True) as partial:
            partial.write_text(text)
    if not args.quiet:
        surface_on_stdout = getattr(args, "target", None) == STREAM
        print(*summary, sep="\n", file=sys.stderr if surface_on_stdout else sys.stdout, flush=True)


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


def mesh_row(label: str, name: str, vertices: int, faces: int) -> str:
    """The line of a mesh: name and size."""
    return row(label, f"{name}: {vertices} vertices, {faces} faces")


def angle_row(angles: Mapping[str, float]) -> str:
    """The line of the angle differences, from `angle_figures`."""
    return row(
        "angles",
        "differ by {mean:.3g} degrees on average (median {median:.3g}, 95% below {p95:.3g}, "
        "99% below {p99:.3g}, at most {max:.3g})".format(**angles),
    )


def log_row(label: str, figures: Mapping[str, float]) -> str:
    """The line of logarithms of areas or lengths, from `log_figures`."""
    return row(label, "log(image / source) is {mean:.3g} on average (99% below {p99:.3g}, at most {max:.3g})".format(
        **figures))


def energy_row(energy: float) -> str:
    """The line of the harmonic energy, eq. (6)."""
    return row("energy", f"{energy:.6f}, which is 4 pi {energy - 4 * math.pi:+.2e} (4 pi: a smooth conformal map)")


def certificate_figures(certificate: Certificate) -> dict[str, Any]:
    """A certificate for JSON: counts, and the first faces of each fault."""
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
