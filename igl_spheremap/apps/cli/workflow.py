"""The way of every command that maps: map, write, certify what was written, draw, and report."""

from argparse import Namespace
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from ...maps.sphere_map import SphereMap
from ...mesh.timings import phase
from ...plane.plane_map import PlaneMap
from ...result.run import Iterate, Listener, Status
from ...verify.certificate import Certificate
from .exits import Exit, Interrupt
from .output import Findings, keeps_target

M = TypeVar("M", SphereMap, PlaneMap)

_LISTENING = "listening"


def map_and_report(
    args: Namespace,
    name: str,
    solve: Callable[[Listener], M],
    listeners: Iterable[Listener | None],
    write: Callable[[M], tuple[Certificate, Findings]],
    draw: Callable[[M], Path | None],
) -> Exit:
    """Map what is called `name` by a function of a listener; Exit.OK means that the numbers in the file are certified.

    `write` writes the map, and returns the certificate of the file and what was found; `draw` returns the page that it
    wrote, if there is one. A signal ends the run early, with the map that there is.
    """
    args.progress.begin(f"mapping {name}")
    with Interrupt() as interrupt:
        heard: list[Listener] = [*filter(None, listeners), interrupt]

        @phase(_LISTENING)
        def listen(iterate: Iterate) -> None:
            for listener in heard:
                listener(iterate)

        result = solve(listen)
    timings = dict(result.timings)  # without the time of the progress line and the recording
    run = replace(result.run, seconds=result.seconds - timings.pop(_LISTENING, 0.0), timings=timings)
    result = replace(result, run=run)
    interrupted = interrupt.status if interrupt.asked and result.status is Status.STOPPED else None
    if keeps_target(args, result.certificate, interrupted):
        assert interrupted is not None
        return interrupted
    certificate, found = write(result)
    page = draw(result)
    found.written(plot=args.plot, report=page)
    found.report(args)
    if interrupted is not None:
        return interrupted
    return Exit.OK if result.certificate.folding_free and certificate.folding_free else Exit.UNCERTIFIED
