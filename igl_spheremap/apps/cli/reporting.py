"""--report and --plot: what a run went through, as a page and as curves."""

from __future__ import annotations

import shlex
from argparse import ArgumentParser, Namespace
from pathlib import Path

from ...descent.recording import Recording
from ...draw.plot import FORMATS, plot_run
from ...errors import import_optional
from ...io.replacing import check_writable, replacing
from ...maps.sphere_map import SphereMap
from ..report import write_report
from ..viewer import guess_up
from .command import UsageError
from .source import Source


def add_reporting(parser: ArgumentParser) -> None:
    """Add the flags.

    Parameters
    ----------
    parser : ArgumentParser
        Gains them.

    Returns
    -------
    None
    """
    parser.add_argument(
        "--report", metavar="DIR", help="write DIR/report.html: figures, pictures and curves on one page"
    )
    parser.add_argument(
        "--plot", metavar="FILE", help="draw energy, foldings and angle differences: .png, .svg or .pdf"
    )


def check_reporting(args: Namespace) -> None:
    """Say before the work starts if it can't be told.

    Parameters
    ----------
    args : Namespace
        With ``report`` and ``plot``.

    Returns
    -------
    None
    """
    if args.plot is not None:
        if Path(args.plot).suffix.lower() not in FORMATS:
            raise UsageError(f"--plot {args.plot}: the name must end in one of {', '.join(FORMATS)}")
        check_writable(args.plot, force=True)
    for flag in ("report", "plot"):
        if getattr(args, flag) is not None:
            import_optional("matplotlib", f"--{flag}", "plot")


def recorder(args: Namespace, source: Source) -> Recording | None:
    """A listener that keeps what will be told, if anything will.

    Parameters
    ----------
    args : Namespace
        With ``report`` and ``plot``.
    source : Source
        The mesh.

    Returns
    -------
    Recording or None
        To be called with every iterate.
    """
    return Recording(source.f) if args.report is not None or args.plot is not None else None


def put_report(args: Namespace, source: Source, result: SphereMap, recording: Recording | None) -> None:
    """Write what the flags ask for.

    Parameters
    ----------
    args : Namespace
        With ``report``, ``plot`` and ``words``.
    source : Source
        The mesh.
    result : SphereMap
        Its map.
    recording : Recording or None
        From `recorder`.

    Returns
    -------
    None
    """
    if recording is None:
        return
    if args.plot is not None:
        figure = plot_run(
            recording.history, recording.foldings, result.angle_differences(), title=f"{source.name}, {result.method}"
        )
        with replacing(args.plot, force=True) as partial:
            figure.savefig(partial, format=Path(args.plot).suffix[1:].lower(), dpi=150)
    if args.report is not None:
        command = [shlex.join(("igl-spheremap", *args.words))]
        write_report(
            Path(args.report), result, recording, source=source.name, command=command, up=guess_up(source.name)
        )
