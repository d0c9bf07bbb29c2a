"""--report and --plot: the course of a run, as a page and as curves."""

from __future__ import annotations

import shlex
from argparse import Namespace
from pathlib import Path

from ...draw.plot import FORMATS
from ...errors import import_optional
from ...io.replacing import replacing
from ...result.recording import Recording, plot_run
from ...result.sphere_map import SphereMap
from ..report import write_report
from ..viewer.choices import guess_up
from .failures import UsageError
from .source import Source


def check_reporting(args: Namespace) -> None:
    """Raise an error before the work starts if the flags can't be served."""
    if args.plot is not None and Path(args.plot).suffix.lower() not in FORMATS:
        raise UsageError(f"--plot {args.plot}: the name must end in one of {', '.join(FORMATS)}")
    for flag in ("--plot", "--report"):
        if getattr(args, flag.lstrip("-")) is not None:
            import_optional("matplotlib", flag, "plot")


def recorder(args: Namespace, source: Source) -> Recording | None:
    """A listener that keeps what the flags ask for; None without them."""
    return Recording(source.f) if args.report is not None or args.plot is not None else None


def write_reports(args: Namespace, source: Source, result: SphereMap, recording: Recording | None) -> None:
    """Write what the flags ask for."""
    if recording is None:
        return
    if args.plot is not None:
        args.progress.stage(f"drawing {args.plot}")
        figure = plot_run(
            recording.history, recording.foldings, result.angle_differences(), title=f"{source.name}, {result.method}"
        )
        with replacing(args.plot, force=True) as partial:
            figure.savefig(partial, format=Path(args.plot).suffix[1:].lower(), dpi=150)
    if args.report is not None:
        args.progress.stage(f"drawing the report in {args.report}")
        command = shlex.join(("igl-spheremap", *args.words))
        write_report(
            Path(args.report), result, recording, source=source.name, command=command, up=guess_up(source.name)
        )
