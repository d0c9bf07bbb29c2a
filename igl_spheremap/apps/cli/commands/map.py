"""`map`: map, write, certify the file, and report."""

import os
from argparse import Namespace
from typing import Any

from ....balance.balanced_spherical_map import balanced_spherical_map
from ....draw.run import plot_run
from ....io.written_map import SphereCheck
from ....maps.sphere_map import ROUNDS, SphereMap, map_findings, round_rows
from ....result.findings import certificate_numbers, moved_for_float32
from ....result.recording import Recording
from ....result.result import run_findings
from ....result.run import Listener
from ....verify.certificate import Certificate
from ...report import write_report
from ..arguments import chosen_method
from ..exits import Exit, UsageError
from ..inputs import InputMesh, load_source
from ..output import Findings, aligned, check_outputs, check_plots, target_format, write_sphere
from ..workflow import as_written, map_and_report


def run_map(args: Namespace) -> Exit:
    check_outputs(args, surface=True)
    check_plots(args)
    if args.radius is not None and target_format(args).name == "NPZ":
        raise UsageError("--radius: an .npz file holds the unit sphere; write another format")
    if args.with_surface and not target_format(args).both:
        raise UsageError(
            f"--with-surface: {target_format(args).name} files hold no sphere beside a surface; write a "
            ".ply file"
        )
    method, source = chosen_method(args), load_source(args)
    recording = Recording(source.f)

    def solve(listener: Listener) -> SphereMap:
        return balanced_spherical_map(
            source.v,
            source.f,
            balance=args.balance,
            method=method,
            caps=source.caps,
            listener=listener,
        )

    def write(result: SphereMap) -> tuple[Certificate, Findings]:
        written = write_sphere(args, result, source, radius=args.radius, surface=args.with_surface)
        return written, _findings(source, args, result, written)

    def plot(result: SphereMap) -> Any:
        return plot_run(
            recording.history,
            recording.foldings,
            result.angle_differences(),
            result.log_area_ratios(),
            title=f"{os.path.basename(source.name)}, {result.method}",
        )

    listeners: list[Listener] = [args.progress.listener(source.f)]
    if args.report or args.plot:
        listeners.insert(0, recording)
    return map_and_report(
        args,
        source,
        solve,
        listeners,
        write,
        plot,
        lambda place, result, **about: write_report(place, result, recording, **about),
    )


def _findings(
    source: InputMesh, args: Namespace, result: SphereMap, written: SphereCheck
) -> Findings:
    found = Findings(
        target=args.target,
        balance=result.balance,
        gauge=result.gauge,
        stretch=result.stretch,
        notes=result.notes,
    )
    found.source(source)
    found.extend(run_findings(result))
    found.lines += _rounds(result)
    found.extend(map_findings(result))
    kind, radius = target_format(args).name, written.radius
    said = as_written(result.certificate, written, ".obj, .ply or .npz")
    if written.folding_free and written.moved:
        said += f", {moved_for_float32(written.moved)}"
    found.add("written", f"{args.target} ({kind}, radius {radius:.6g}), {said}")
    found.figures["file"] = {
        "format": kind,
        "radius": radius,
        "moved": written.moved,
        "certificate": certificate_numbers(written),
    }
    return found


def _rounds(result: SphereMap) -> list[str]:
    """The foldings before and after each round, as a table."""
    if not result.rounds:
        return []
    return ["", *aligned([ROUNDS, *round_rows(result)], left=2), ""]
