"""`map`, `p-harmonic` and `landmarks`: map, write, certify what was written, and report."""

import os
from argparse import Namespace
from collections.abc import Callable
from typing import Any

import numpy as np

from ....io.written_map import SphereCheck, write_map
from ....maps.balanced import balanced_spherical_map
from ....maps.sphere_map import ROUNDS, SphereMap, map_findings, round_rows
from ....maps.variational import landmark_map, p_harmonic_map
from ....mesh.arrays import FloatArray, IntArray
from ....result.findings import certificate_numbers
from ....result.recording import Recording, plot_run
from ....result.result import run_findings
from ....result.run import Iterate, title_of
from ....sphere.rows import unit_rows
from ....verify.certificate import Certificate
from ...report import write_report
from ..arguments import chosen_method, given
from ..exits import Exit, UsageError
from ..inputs import InputMesh, load_source, read_points
from ..output import (
    LISTED,
    Findings,
    aligned,
    check_outputs,
    check_plots,
    target_format,
    write_target,
)
from ..progress import measures
from ..workflow import map_and_report


def run_map(args: Namespace) -> Exit:
    """Map a closed genus-0 mesh to the unit sphere and certify the map.

    igl-spheremap map sample:bunny bunny_sphere.obj
    igl-spheremap map lh.pial lh.sphere.conformal
    igl-spheremap map bunny.ply bunny_map.npz --method lai2014 --json figures.json
    igl-spheremap map bunny.ply bunny_sphere.ply --report bunny_report --plot bunny.svg
    igl-spheremap map scan.stl sphere.ply --repair --keep-largest
    igl-spheremap map bunny.ply bunny_sphere.ply --polish angles
    """
    options = {"balance": args.balance, "method": chosen_method(args)}
    return _map_by(args, lambda v, f, **more: balanced_spherical_map(v, f, **options, **more))


def run_p_harmonic(args: Namespace) -> Exit:
    """Map by the p-harmonic energy, which gives limbs more room for p above 2.

    igl-spheremap p-harmonic sample:dino dino_sphere.obj -p 4
    """
    options = _variational(args)
    return _map_by(args, lambda v, f, **more: p_harmonic_map(v, f, args.p, **options, **more))


def run_landmarks(args: Namespace) -> Exit:
    """Map harmonically with landmarks moved towards targets.

    igl-spheremap landmarks lh.pial lh.sphere.conformal --points landmarks.txt --weight 100
    igl-spheremap landmarks bird.off bird.ply --points bird.pinned --onto plane.pinned plane_sphere.ply
    """
    vertices, targets, weights = read_points(args.points, args.weight, args.onto)
    options = _variational(args)
    return _map_by(
        args,
        lambda v, f, **more: landmark_map(v, f, vertices, targets, landmark_weights=weights, **options, **more),
        lambda found, result: _misses(found, result.sphere[vertices], targets, vertices),
    )


def _variational(args: Namespace) -> dict[str, Any]:
    return given(args, "gradient_tolerance", "sobolev_gradient_tolerance", "max_iterations", "may_fold")


def _misses(found: Findings, x: FloatArray, targets: FloatArray, vertices: IntArray) -> None:
    """Degrees between landmarks (k, 3) and their targets, in the order of the file."""
    misses = np.degrees(2 * np.arcsin(np.minimum(np.linalg.norm(x - unit_rows(targets), axis=1) / 2, 1)))
    for k, miss in zip(vertices[:LISTED], misses, strict=False):
        found.add(f"vertex {k}", f"misses its target by {miss:.3g} degrees")
    more = f", and {len(misses) - LISTED} more that --json lists" if len(misses) > LISTED else ""
    found.add("landmarks", f"miss by {misses.mean():.3g} degrees on average, at most {misses.max():.3g}{more}",
              landmarks=[{"vertex": k, "miss": miss} for k, miss in zip(vertices, misses, strict=True)])


def _map_by(
    args: Namespace,
    solve: Callable[..., SphereMap],
    more: Callable[[Findings, SphereMap], None] = lambda found, result: None,
) -> Exit:
    """Map by a function of v, f, caps and a listener; `more` adds to what was found."""
    check_outputs(args, surface=True)
    check_plots(args)
    if args.radius is not None and target_format(args).name == "NPZ":
        raise UsageError("--radius: an .npz file holds the unit sphere; write another format")
    if args.with_surface and not target_format(args).both:
        raise UsageError(f"--with-surface: {target_format(args).name} files hold no sphere beside a surface; write a "
                         ".ply file")
    source = load_source(args)
    recording = Recording(source.f)

    def log(iterate: Iterate) -> None:
        args.progress.write(f"{title_of(iterate)}: {measures(iterate)}, tau {iterate.tau:.2e}")

    def write(result: SphereMap) -> tuple[Certificate, Findings]:
        written = write_target(
            args,
            lambda path: write_map(path, result, force=args.force, radius=args.radius, surface=args.with_surface,
                                   metadata=source.metadata),
        )
        found = _findings(source, args, result, written)
        more(found, result)
        return written, found

    def plot(result: SphereMap) -> Any:
        return plot_run(recording.history, recording.foldings, result.angle_differences(), result.log_area_ratios(),
                        title=f"{os.path.basename(source.name)}, {result.method}")

    return map_and_report(
        args, source, lambda listener: solve(source.v, source.f, caps=source.caps, listener=listener),
        (recording if args.report or args.plot else None, log if args.verbose else args.progress.listener(source.f)),
        write, plot,
        lambda place, result, **about: write_report(place, result, recording, **about),
    )  # fmt: skip


def _findings(source: InputMesh, args: Namespace, result: SphereMap, written: SphereCheck) -> Findings:
    found = Findings(target=args.target, balance=result.balance, gauge=result.gauge, stretch=result.stretch,
                     notes=result.notes)
    found.source(source)
    method, *notes = run_findings(result)
    found.extend([method])
    if args.timings:
        found.lines += _timings(result)
    found.extend(notes)
    found.lines += _rounds(result)
    found.extend(map_findings(result))
    kind, radius = target_format(args).name, written.radius
    found.add("written", f"{args.target} ({kind}, radius {radius:.6g}), {_as_written(result, written)}")
    found.figures["file"] = {
        "format": kind,
        "radius": radius,
        "moved": written.moved,
        "certificate": certificate_numbers(written),
    }
    return found


def _timings(result: SphereMap) -> list[str]:
    """Seconds and share of each phase, and of what belongs to none."""
    phases = result.timings | {"other": result.seconds - sum(result.timings.values())}
    return [f"{'' if k else 'time':13}{seconds:8.4f} s {seconds / result.seconds:6.1%}  {name}"
            for k, (name, seconds) in enumerate(phases.items())]


def _rounds(result: SphereMap) -> list[str]:
    """The foldings before and after each round, as a table."""
    if not result.rounds:
        return []
    return ["", *aligned([ROUNDS, *round_rows(result)], left=2), ""]


def _as_written(result: SphereMap, written: SphereCheck) -> str:
    if written.folding_free:
        moved = f", {written.moved} vertices moved to keep float32 from folding" if written.moved else ""
        return "certified as written" + moved
    if result.certificate.folding_free:
        return (
            f"but rounded to this format it is {written}; write .obj, .ply or .npz, "
            "which keep every digit"
        )
    return "not certified"
