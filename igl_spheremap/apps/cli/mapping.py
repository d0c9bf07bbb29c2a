"""Map, write, certify what was written, and report: what `map`, `p-harmonic` and `landmarks` share."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable
from dataclasses import replace

from ...io import SphereCheck, write_map
from ...mesh.timings import stage
from ...result.run import Iterate, Listener, Status, title_of
from ...result.sphere_map import ROUNDS, SphereMap, round_rows
from .exits import Exit
from .failures import UsageError
from .interrupt import Interrupt
from .output import Findings, certificate_figures, row
from .progress import measures
from .reporting import check_reporting, recorder, write_reports
from .source import Source, load_source
from .streams import check_outputs, target_format, write_target

_LISTENING = "listening"


def map_by(
    args: Namespace,
    solve: Callable[..., SphereMap],
    more: Callable[[Findings, SphereMap], None] = lambda found, result: None,
) -> Exit:
    """Map by a function of v, f and a listener.

    `more` adds to what was found. Exit.OK means that the numbers in the file are certified.
    """
    check_outputs(args, surface=True)
    check_reporting(args)
    if args.radius is not None and target_format(args).name == "NPZ":
        raise UsageError("--radius: an .npz file holds the unit sphere; write another format")
    source = load_source(args)
    recording = recorder(args, source)
    result, interrupted = _map(source, args, solve, recording)
    written = write_target(
        args,
        lambda path: write_map(path, result, force=args.force, radius=args.radius, metadata=source.metadata),
    )
    write_reports(args, source, result, recording)
    found = _findings(source, args, result, written)
    more(found, result)
    found.report(args)
    if interrupted is not None:
        return interrupted
    certified = result.certificate.folding_free and written.certificate.folding_free
    return Exit.OK if certified else Exit.UNCERTIFIED


def _map(
    source: Source, args: Namespace, solve: Callable[..., SphereMap], recording: Listener | None
) -> tuple[SphereMap, Exit | None]:
    """The map, and the exit status if a signal ended it early."""
    def log(iterate: Iterate) -> None:
        args.progress.write(f"{title_of(iterate)}: {measures(iterate)}, tau {iterate.tau:.2e}")

    args.progress.stage(f"mapping {source.name}")
    with Interrupt() as interrupt:
        listeners = (recording, log if args.verbose else args.progress.listener(source.f), interrupt)

        @stage(_LISTENING)
        def listen(iterate: Iterate) -> None:
            for listener in filter(None, listeners):
                listener(iterate)

        result = solve(source.v, source.f, listener=listen)
        timings = dict(result.timings)  # without the time of the progress line and the recording
        result = replace(result, seconds=result.seconds - timings.pop(_LISTENING, 0.0), timings=timings)
    return result, interrupt.status if interrupt.asked and result.status is Status.STOPPED else None


def _findings(source: Source, args: Namespace, result: SphereMap, written: SphereCheck) -> Findings:
    found = Findings(
        target=args.target, settings=result.settings, timings=result.timings, balance=result.balance,
        gauge=result.gauge, stretch=result.stretch, notes=result.notes,
        rounds=[entry.__dict__ | {"status": entry.status.name} for entry in result.rounds],
    )  # fmt: skip
    found.source(source)
    backend = f", {result.backend}" if result.backend else ""
    found.add(
        "method",
        f"{result.method}{backend}: {result.iterations} iterations, {result.seconds:.2f} s; {result.status.value}",
        method=result.method, backend=result.backend, iterations=result.iterations, seconds=result.seconds,
        status=result.status.name,
    )  # fmt: skip
    if args.timings:
        found.lines += _timings(result)
    for note in result.notes:
        found.add("note", note)
    found.lines += _rounds(result)
    found.energy(result.energy)
    found.angles(result.angle_differences())
    found.ratios("area", result.area_ratios())
    if result.stretch != 1:
        advice = "" if result.gauge == "poles" else "; without --gauge centred they may keep their angles"
        found.add("stretch", f"limbs too deep for float64 are mapped as if {result.stretch:.3g} times shorter{advice}")
    found.certificate(result.certificate)
    kind, radius = target_format(args).name, written.radius
    found.add("written", f"{args.target} ({kind}, radius {radius:.6g}), {_as_written(result, written)}")
    found.figures["file"] = {
        "format": kind,
        "radius": radius,
        "moved": written.moved,
        "certificate": certificate_figures(written.certificate),
    }
    return found


def _timings(result: SphereMap) -> list[str]:
    """Seconds and share of each stage, and of what belongs to none."""
    stages = result.timings | {"other": result.seconds - sum(result.timings.values())}
    return [row("time" if k == 0 else "", f"{seconds:8.4f} s {seconds / result.seconds:6.1%}  {name}")
            for k, (name, seconds) in enumerate(stages.items())]


def _rounds(result: SphereMap) -> list[str]:
    """The foldings before and after each round, as a table."""
    if not result.rounds:
        return []
    shape = "  {:<6}{:<20.18}{:>16}{:>12}{:>12}{:>12}"
    return ["", *(shape.format(*cells) for cells in (ROUNDS, *round_rows(result))), ""]


def _as_written(result: SphereMap, written: SphereCheck) -> str:
    if written.certificate.folding_free:
        moved = f", {written.moved} vertices moved to keep float32 from folding" if written.moved else ""
        return "certified as written" + moved
    if result.certificate.folding_free:
        return (
            f"but rounded to this format it is {written.certificate}; write .obj, .ply or .npz, "
            "which keep every digit"
        )
    return "not certified"
