"""`igl-spheremap map IN OUT`: map a mesh to the sphere and write it."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from typing import Any, get_args

from ...descent.iterate import Iterate, Listener, Status
from ...io import SphereCheck, write_map
from ...maps.methods import METHODS
from ...maps.methods.auto import Gauge
from ...maps.sphere_map import SphereMap
from ...maps.spherical_conformal_map import spherical_conformal_map
from ...untangle.relax import Polish
from ...verify.figures import angle_figures
from .command import Command, UsageError
from .exits import Exit
from .output import add_output, angle_row, certificate_figures, check_json, energy_row, put_out, row
from .reporting import add_reporting, check_reporting, put_report, recorder
from .source import Source, add_source, load_source, tell_repairs
from .status_line import Interrupt, IterationLog, StatusLine
from .streams import check_target, target_format, write_target


def configure(parser: ArgumentParser) -> None:
    """Add the arguments of `map`.

    Parameters
    ----------
    parser : ArgumentParser
        Gains them.

    Returns
    -------
    None
    """
    add_map_arguments(parser)
    parser.add_argument(
        "--method", choices=tuple(METHODS), default="auto", help="default: auto, the fast pipeline"
    )
    parser.add_argument(
        "--polish",
        choices=get_args(Polish),
        help="lower the angle differences, or their largest ones, when the map is done (auto)",
    )
    parser.add_argument(
        "--gauge",
        choices=get_args(Gauge),
        help="poles: the two deepest tips at the poles, for bodies beyond float64 (auto); default: centred",
    )


def add_map_arguments(parser: ArgumentParser) -> None:
    """Add what all commands take that map a mesh and write the map.

    Parameters
    ----------
    parser : ArgumentParser
        Gains them.

    Returns
    -------
    None
    """
    add_source(parser)
    parser.add_argument(
        "target", metavar="OUT", help="the sphere, same vertex order; .npz holds the whole result; - for stdout"
    )
    parser.add_argument("-f", "--force", action="store_true", help="replace OUT if it exists")
    parser.add_argument(
        "--tolerance", type=float, metavar="T", help="of the stopping rule; default: the method's"
    )
    parser.add_argument("--max-iterations", type=int, metavar="N", help="default: the method's")
    parser.add_argument(
        "--radius",
        type=float,
        metavar="R",
        help="of the sphere in OUT; default: 100 for GIFTI and FreeSurfer, 1 elsewhere",
    )
    add_reporting(parser)
    add_output(parser)
    parser.add_argument("-v", "--verbose", action="store_true", help="log every iteration on stderr")


def run(args: Namespace) -> Exit:
    """Map conformally, write, certify what was written, and tell.

    Parameters
    ----------
    args : Namespace
        As configured.

    Returns
    -------
    Exit
        OK only with the certificate of the numbers in the file.
    """
    chosen = {name: getattr(args, name) for name in ("polish", "gauge") if getattr(args, name) is not None}
    if chosen and args.method != "auto":
        raise UsageError(f"--{' and --'.join(chosen)} go with --method auto only, not with {args.method}")
    return map_by(args, lambda v, f, **options: spherical_conformal_map(v, f, args.method, **chosen, **options))


def map_by(args: Namespace, solve: Callable[..., SphereMap]) -> Exit:
    """Map by any function, write, certify what was written, and tell.

    Parameters
    ----------
    args : Namespace
        As `add_map_arguments` configures them.
    solve : callable
        Takes vertices, faces, a ``listener``, and ``tolerance`` and ``max_iterations`` where they were given.

    Returns
    -------
    Exit
        OK only with the certificate of the numbers in the file.
    """
    if args.radius is not None and not 0 < args.radius < float("inf"):
        raise UsageError(f"--radius {args.radius:g} is not positive")
    check_target(args)
    check_json(args)
    check_reporting(args)
    source = load_source(args)
    tell_repairs(source)
    recording = recorder(args, source)
    result, interrupted = _map(source, args, solve, [] if recording is None else [recording])
    written = write_target(
        args,
        lambda path: write_map(path, result, force=args.force, radius=args.radius, metadata=source.metadata),
    )
    put_report(args, source, result, recording)
    put_out(args, _figures(source, args, result, written), _summary(source, args, result, written))
    if interrupted:
        return Exit.INTERRUPTED
    certified = result.certificate.folding_free and written.certificate.folding_free
    return Exit.OK if certified else Exit.FOLDINGS


def _map(
    source: Source, args: Namespace, solve: Callable[..., SphereMap], recorders: list[Listener]
) -> tuple[SphereMap, bool]:
    """The map, and whether Ctrl-C ended it early."""
    options: dict[str, Any] = {
        key: value
        for key, value in (("tolerance", args.tolerance), ("max_iterations", args.max_iterations))
        if value is not None
    }
    line = StatusLine(sys.stderr, source.f)
    with Interrupt() as interrupt:
        listeners: list[Listener] = [*recorders, IterationLog(sys.stderr) if args.verbose else line, interrupt]

        def tell(iterate: Iterate) -> None:
            for listener in listeners:
                listener(iterate)

        try:
            result = solve(source.v, source.f, listener=tell, **options)
        finally:
            line.clear()
    return result, interrupt.asked and result.status is Status.STOPPED


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
        "energy": result.energy,
        "angle_differences": angle_figures(result.angle_differences()),
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


def _summary(source: Source, args: Namespace, result: SphereMap, written: SphereCheck) -> str:
    backend = f", {result.backend}" if result.backend else ""
    lines = [
        row("source", f"{source.name}: {len(result.vertices)} vertices, {len(result.faces)} faces"),
        row(
            "method",
            f"{result.method}{backend}: {result.iterations} iterations, {result.seconds:.2f} s; "
            f"{result.status.value}",
        ),
        *(row("note", note) for note in result.notes),
        *_rounds(result),
        energy_row(result.energy),
        angle_row(angle_figures(result.angle_differences())),
        *_beyond_float64(result),
        row("certificate", str(result.certificate)),
        row(
            "written",
            f"{args.target} ({target_format(args).name}, radius {written.radius:.6g}), "
            f"{_as_written(result, written)}",
        ),
    ]
    return "\n".join(lines)


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
    """What had to give where limbs are too deep for floating point."""
    if result.stretch == 1:
        return []
    advice = "" if result.gauge == "poles" else "; --gauge poles may do better"
    return [row("stretch", f"limbs beyond float64 are drawn out {result.stretch:.3g} times as long{advice}")]


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


COMMAND = Command(
    "map",
    "map a closed genus-0 mesh to the unit sphere and certify the map",
    """\
igl-spheremap map sample:dino dino_sphere.obj
igl-spheremap map lh.pial lh.sphere
igl-spheremap map bunny.ply bunny_map.npz --method lai2014 --json figures.json
igl-spheremap map bunny.ply bunny_sphere.ply --report bunny_report --plot bunny.svg
igl-spheremap map scan.stl sphere.ply --repair --keep-largest
igl-spheremap map bunny.ply bunny_sphere.ply --polish angles""",
    configure,
    run,
)
