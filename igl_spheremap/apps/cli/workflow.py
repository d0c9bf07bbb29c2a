"""The way of every command that maps: map, write, certify the file, draw, and report."""

import os
from argparse import Namespace
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar

from ...io.replacing import replacing
from ...maps.sphere_map import SphereMap
from ...plane.plane_map import PlaneMap
from ...result.run import Iterate, Listener, Status
from ...verify.certificate import Certificate
from .exits import Exit, Interrupt
from .inputs import STREAM, InputMesh, up_of
from .output import Findings, command_of

M = TypeVar("M", SphereMap, PlaneMap)


def as_written(result: Certificate, written: Certificate, exact: str) -> str:
    """The verdict on a map as it stands in its file; `exact` names formats that keep every digit."""
    if written.folding_free:
        return "certified as written"
    if result.folding_free:
        return f"but rounded to this format it is {written}; write {exact}, which keep every digit"
    return "not certified"


def map_and_report(
    args: Namespace,
    source: InputMesh,
    solve: Callable[[Listener], M],
    listeners: Iterable[Listener],
    write: Callable[[M], tuple[Certificate, Findings]],
    plot: Callable[[M], Any],
    page: Callable[..., Path],
) -> Exit:
    """Map a surface by a function of a listener; Exit.OK means that the numbers in the file are certified.

    `write` writes the map, and returns the certificate of the file and findings; `plot` makes the figure of --plot, and
    `page` writes that of --report. A signal ends the run early, with the present map.
    """
    args.progress.begin(f"mapping {source.name}")
    with Interrupt() as interrupt:
        heard: list[Listener] = [*listeners, interrupt]

        def listen(iterate: Iterate) -> None:
            for listener in heard:
                listener(iterate)

        result = solve(listen)
    interrupted = interrupt.asked and result.status is Status.STOPPED
    exists = args.target != STREAM and os.path.exists(args.target)
    if interrupted and exists and not result.certificate.folding_free:
        args.progress.write(
            f"igl-spheremap: interrupted with {result.certificate.foldings} foldings; {args.target} is "
            "kept as it was"
        )
        return interrupt.status
    certificate, found = write(result)
    if args.plot is not None:
        args.progress.begin(f"drawing {args.plot}")
        with replacing(args.plot, force=True) as partial:
            plot(result).savefig(partial, format=Path(args.plot).suffix[1:].lower(), dpi=150)
    report = None
    if args.report is not None:
        args.progress.begin(f"drawing the report in {args.report}")
        report = page(
            args.report,
            result,
            source=os.path.basename(source.name),
            up=up_of(args, source),
            command=command_of(args),
        )
    found.written(plot=args.plot, report=report)
    status = found.report(args, result.certificate, certificate)
    if interrupted:
        return interrupt.status
    return status
