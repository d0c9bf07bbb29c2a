"""Figures of a run: for people in 80 columns on stdout, for machines as JSON."""

from __future__ import annotations

import json
import math
import sys
import textwrap
from argparse import ArgumentParser, Namespace
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...io.replacing import check_writable, replacing
from ...verify.certificate import Certificate

WIDTH = 80
_LABEL = 13
_SHOWN = 10  # faces that JSON lists of each kind of fault


def add_output(parser: ArgumentParser) -> None:
    """Add the flags that all commands share.

    Parameters
    ----------
    parser : ArgumentParser
        Gains the flags.

    Returns
    -------
    None
    """
    parser.add_argument(
        "--json", metavar="FILE", help="write the figures as JSON; '-' is stdout, instead of the summary"
    )
    parser.add_argument("-q", "--quiet", action="store_true", help="print no summary")


def check_json(args: Namespace) -> None:
    """Say before the work starts if the JSON file can't be written.

    Parameters
    ----------
    args : Namespace
        With ``json``.

    Returns
    -------
    None
    """
    if args.json not in (None, "-"):
        check_writable(args.json, force=True)


def put_out(args: Namespace, figures: Mapping[str, Any], summary: str) -> None:
    """Print the summary and write the JSON, as the flags say.

    Parameters
    ----------
    args : Namespace
        With ``json`` and ``quiet``.
    figures : dict
        For the machine.
    summary : str
        For people.

    Returns
    -------
    None
    """
    if args.json is not None:
        text = json.dumps(_plain(figures), indent=2, allow_nan=False) + "\n"
        if args.json == "-":
            sys.stdout.write(text)
            sys.stdout.flush()
            return
        with replacing(args.json, force=True) as partial:
            partial.write_text(text)
    if not args.quiet:
        in_the_way = getattr(args, "target", None) == "-"  # stdout holds the surface then
        print(summary, file=sys.stderr if in_the_way else sys.stdout, flush=True)


def row(label: str, text: str) -> str:
    """A labelled paragraph of the summary.

    Parameters
    ----------
    label : str
        At most 12 characters.
    text : str
        Wrapped at 80 columns behind the label.

    Returns
    -------
    str
        Its lines.

    Examples
    --------
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


def certificate_figures(certificate: Certificate) -> dict[str, Any]:
    """A certificate for the machine: counts, and the first few of each fault.

    Parameters
    ----------
    certificate : Certificate
        Of a map.

    Returns
    -------
    dict
        Plain numbers and lists.
    """
    figures: dict[str, Any] = {"folding_free": certificate.folding_free, "degree": certificate.degree}
    for name in ("flipped", "degenerate", "not_finite", "off_sphere"):
        where: Sequence[int] = getattr(certificate, name)
        figures[name] = {"count": len(where), "first": [int(i) for i in where[:_SHOWN]]}
    return figures


def angle_row(angles: Mapping[str, float]) -> str:
    """The line of the summary that tells the angle differences.

    Parameters
    ----------
    angles : dict
        From `angle_figures`.

    Returns
    -------
    str
        One line.
    """
    return row(
        "angles",
        "differ by {mean:.3g} degrees on average (median {median:.3g}, 95% below {p95:.3g}, "
        "99% below {p99:.3g}, at most {max:.3g})".format(**angles),
    )


def energy_row(energy: float) -> str:
    """The line of the summary that tells the harmonic energy.

    Parameters
    ----------
    energy : float
        Of eq. (6).

    Returns
    -------
    str
        One line.
    """
    return row(
        "energy", f"{energy:.6f}, which is 4 pi {energy - 4 * math.pi:+.2e} (4 pi: a smooth conformal map)"
    )


def _plain(value: Any) -> Any:
    """Numbers, strings, lists and dicts only; what is not finite becomes null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.generic | np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int | str) else str(value)
