"""Map, write, certify what was written, and report: what `map`, `p-harmonic` and `landmarks` share."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from ...descent.iterate import Iterate, Listener, Status
from ...io import SphereCheck, write_map
from ...maps.sphere_map import SphereMap
from ...mesh.timings import stage
from ...verify.figures import angle_figures, log_figures
from .exits import Exit
from .interrupt import Interrupt
from .output import angle_row, certificate_figures, energy_row, log_row, mesh_row, report, row
from .progress import measures
from .reporting import check_reporting, recorder, write_reports
from .source import Source, load_source
from .streams import check_outputs, target_format, write_target

_LISTENING = "listening"


def map_by(
    args: Namespace,
    solve: Callable[..., SphereMap],
    more: Callable[[SphereMap], tuple[dict[str, Any], list[str]]] = lambda result: ({}, []),
) -> Exit:
    """Map by a function of v, f and a listener.

    `more` is what the figures and the summary report besides. Exit.OK means that the numbers in the file are certified.
    """
    check_outputs(args, surface=True)
    check_reporting(args)
    source = load_source(args)
    recording = recorder(args, source)
    result, interrupted = _map(source, args, solve, recording)
    written = write_target(
        args,
        lambda path: write_map(path, result, force=args.force, radius=args.radius, metadata=source.metadata),
    )
    write_reports(args, source, result, recording)
    figures, rows = more(result)
    report(args, _figures(source, args, result, written) | figures, _summary(source, args, result, written) + rows)
    if interrupted is not None:
        return interrupted
    certified = result.certificate.folding_free and written.certificate.folding_free
    return Exit.OK if certified else Exit.FOLDINGS


def _map(
    source: Source, args: Namespace, solve: Callable[..., SphereMap], recording: Listener | None
) -> tuple[SphereMap, Exit | None]:
    """The map, and the exit status if a signal ended it early."""
    def log(iterate: Iterate) -> None:
        name = f"{iterate.stage} {iterate.round}.{iterate.iteration}"
        args.progress.write(f"{name}  {measures(iterate)}, tau {iterate.tau:.2e}")

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


def _figures(source: Source, args: Namespace, result: SphereMap, written: SphereCheck) -> dict[str, Any]:
    return {
        "source": source.name,
        "repairs": source.repairs,
        "target": args.target,
        "vertices": len(result.vertices),
        "faces": len(result.faces),
        "method": result.method,
        "backend": result.backend,
        "settings": result.settings,
        "notes": result.notes,
        "status": result.status.name,
        "iterations": result.iterations,
        "seconds": result.seconds,
        "timings": result.timings,
        "energy": result.energy,
        "balance": result.balance,
        "angle_differences": angle_figures(result.angle_differences()),
        "area_ratios": log_figures(result.area_ratios()),
        "gauge": result.gauge,
        "stretch": result.stretch,
        "rounds": [entry.__dict__ | {"status": entry.status.name} for entry in result.rounds],
        "certificate": certificate_figures(result.certificate),
        "file": {
            "format": target_format(args).name,
            "radius": written.radius,
            "moved": written.moved,
            "certificate": certificate_figures(written.certificate),
        },
    }


def _summary(source: Source, args: Namespace, result: SphereMap, written: SphereCheck) -> list[str]:
    backend = f", {result.backend}" if result.backend else ""
    return [
        mesh_row("source", source.name, len(result.vertices), len(result.faces)),
        row(
            "method",
            f"{result.method}{backend}: {result.iterations} iterations, {result.seconds:.2f} s; "
            f"{result.status.value}",
        ),
        *(_timings(result) if args.timings else ()),
        *(row("note", note) for note in result.notes),
        *_rounds(result),
        energy_row(result.energy),
        angle_row(angle_figures(result.angle_differences())),
        log_row("areas", log_figures(result.area_ratios())),
        *_beyond_float64(result),
        row("certificate", str(result.certificate)),
        row(
            "written",
            f"{args.target} ({target_format(args).name}, radius {written.radius:.6g}), "
            f"{_as_written(result, written)}",
        ),
    ]


def _timings(result: SphereMap) -> list[str]:
    """Seconds and share of each stage, and of what belongs to none."""
    stages = result.timings | {"other": result.seconds - sum(result.timings.values())}
    return [row("time" if k == 0 else "", f"{seconds:8.4f} s {seconds / result.seconds:6.1%}  {name}")
            for k, (name, seconds) in enumerate(stages.items())]


def _rounds(result: SphereMap) -> list[str]:
    """The foldings before and after each round, as a table."""
    if not result.rounds:
        return []
    lines = ["", f"  {'round':<24}{'foldings':>18}{'iterations':>12}{'energy':>12}{'mean angle':>12}"]
    for entry in result.rounds:
        foldings = f"{entry.foldings_before} -> {entry.foldings_after}"
        lines.append(
            f"  {entry.round:>2} {entry.start[:20]:<21}{foldings:>18}{entry.iterations:>12}"
            f"{entry.energy:>12.6f}{entry.mean_angle_difference:>12.3f}"
        )
    return [*lines, ""]


def _beyond_float64(result: SphereMap) -> list[str]:
    """How much limbs beyond floating point were stretched."""
    if result.stretch == 1:
        return []
    advice = "" if result.gauge == "poles" else "; --gauge poles may do better"
    return [row("stretch", f"limbs beyond float64 are stretched to {result.stretch:.3g} times their length{advice}")]


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
