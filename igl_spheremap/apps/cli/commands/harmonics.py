"""`igl-spheremap harmonics SURFACE SPHERE OUT`: coefficients of spherical harmonics."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import Any

from ....errors import MeshError
from ....io import read_coefficients, write_coefficients, write_mesh
from ....io.replacing import replacing
from ....maps.given_sphere import sphere_map
from ....shapes.harmonics.basis import LARGEST_DEGREE
from ....shapes.harmonics.spherical_harmonics import SphericalHarmonics, spherical_harmonics
from ...numbers import number
from ..exits import Exit
from ..failures import UsageError
from ..output import add_output, report, row
from ..pair import add_pair, load_pair
from ..streams import add_target, check_outputs
from ..vertex_data import add_data, read_data


def configure(parser: ArgumentParser) -> None:
    """Add the arguments."""
    add_pair(parser, "SURFACE")
    add_target(parser, "coefficients: .coef as SPHARM-PDM writes them, or .npz")
    degree = number(f"from 0 to {LARGEST_DEGREE}", lambda n: 0 <= n <= LARGEST_DEGREE, int)
    parser.add_argument("--degree", type=degree, default=15, metavar="L", help="the largest degree (default: 15)")
    add_data(parser)
    parser.add_argument("--align", action="store_true", help="put it into the frame of its first-order ellipsoid")
    parser.add_argument("--template", metavar="FILE", help="with --align: an aligned shape that decides the directions")
    parser.add_argument("--surface", metavar="FILE", help="write the surface that the coefficients describe")
    parser.add_argument("--to", metavar="MESH", default="ico:5", help="its mesh: ico:K (default: ico:5)")
    parser.add_argument("--table", metavar="FILE", help="write error and power by degree, separated by tabs")
    add_output(parser)


def run(args: Namespace) -> Exit:
    """Expand, align if asked, write, and report."""
    if args.template and not args.align:
        raise UsageError("--template goes with --align")
    check_outputs(args)
    source, name, x = load_pair(args)
    values = None if args.data is None else read_data(args.data, len(source.v), source.name)
    args.progress.stage(f"expanding {source.name}")
    try:
        harmonics = spherical_harmonics(sphere_map(source.v, source.f, x), values, args.degree)
    except MeshError as problem:
        raise MeshError(f"{name}: {problem}") from None
    figures: dict[str, Any] = {"source": source.name, "sphere": name, "target": args.target, "degree": args.degree}
    summary = [row("source", f"{source.name}: {len(source.v)} vertices, sphere {name}")]
    if args.align:
        aligned = harmonics.align(read_coefficients(args.template) if args.template else None)
        harmonics = aligned.harmonics
        figures |= {"axes": aligned.axes, "skew": aligned.skew}
        axes, skew = (", ".join(f"{number:.3g}" for number in each) for each in (aligned.axes, aligned.skew))
        summary.append(row("axes", f"half axes {axes} along x, y, z; skewness {skew}"))
    error, power = harmonics.error(), harmonics.power()
    figures |= {"error_percent": error, "power": power}
    summary.append(row("error", f"{error[-1]:.3g} percent of the diagonal at degree {args.degree}"))
    args.progress.stage(f"writing {args.target}")
    _write(args, harmonics, error, power)
    summary += [row("written", ", ".join(filter(None, (args.target, args.surface, args.table))))]
    report(args, figures, summary)
    return Exit.OK


def _write(args: Namespace, harmonics: SphericalHarmonics, error: Any, power: Any) -> None:
    """The coefficients, and what else was asked for."""
    write_coefficients(args.target, harmonics, force=args.force)
    if args.surface:
        try:
            write_mesh(args.surface, *harmonics.surface(args.to), force=args.force)
        except ValueError as problem:
            if isinstance(problem, MeshError):
                raise
            raise UsageError(f"--to {problem}") from None
    if args.table:
        lines = [f"{ell}\t{e:.6g}\t{p:.9g}\n" for ell, (e, p) in enumerate(zip(error, power, strict=True))]
        with replacing(args.table, args.force) as partial:
            partial.write_text("degree\terror_percent\tpower\n" + "".join(lines))
