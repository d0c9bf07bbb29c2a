"""Expand a mapped surface, or data over it, in spherical harmonics.

    igl-spheremap harmonics bunny.ply bunny_sphere.ply bunny.coef --degree 15 --table errors.tsv
    igl-spheremap harmonics bunny.ply bunny_sphere.ply bunny.coef --align --surface reconstructed.ply
"""

from __future__ import annotations

from argparse import Namespace

from ....io import read_coefficients, write_coefficients, write_mesh
from ....io.replacing import replacing
from ....mesh.arrays import FloatArray
from ....shapes.harmonics.spherical_harmonics import spherical_harmonics
from ..failures import UsageError
from ..output import Findings
from ..pair import load_pair
from ..streams import check_outputs
from ..vertex_data import read_data, read_target_sphere


def run(args: Namespace) -> None:
    """Expand, align if asked, write, and report."""
    if args.template and not args.align:
        raise UsageError("--template goes with --align")
    check_outputs(args)
    mesh = read_target_sphere(args) if args.surface else None
    pair = load_pair(args)
    source = pair.source
    values = None if args.data is None else read_data(args.data, len(source.v), source.name)
    args.progress.stage(f"expanding {source.name}")
    harmonics = spherical_harmonics(pair.map(), values, args.degree)
    found = Findings(target=args.target)
    found.add("source", f"{source.name}: {len(source.v)} vertices, sphere {pair.name}",
              source=source.name, sphere=pair.name)
    if args.align:
        aligned = harmonics.align(read_coefficients(args.template) if args.template else None)
        harmonics = aligned.harmonics
        axes, skew = (", ".join(f"{number:.3g}" for number in each) for each in (aligned.axes, aligned.skew))
        found.add("axes", f"half axes {axes} along x, y, z; skewness {skew}", axes=aligned.axes, skew=aligned.skew)
    error, power = harmonics.error(), harmonics.power()
    found.add("error", f"{error[-1]:.3g} percent of the diagonal at degree {args.degree}",
              error_percent=error, degree=args.degree, power=power)
    surface = harmonics.surface(mesh) if mesh else None
    args.progress.stage(f"writing {args.target}")
    write_coefficients(args.target, harmonics, force=args.force)
    if surface:
        write_mesh(args.surface, *surface, force=args.force)
    if args.table:
        _write_table(args, error, power)
    found.add("written", ", ".join(filter(None, (args.target, args.surface, args.table))))
    found.report(args)


def _write_table(args: Namespace, error: FloatArray, power: FloatArray) -> None:
    lines = [f"{ell}\t{e:.6g}\t{p:.9g}\n" for ell, (e, p) in enumerate(zip(error, power, strict=True))]
    with replacing(args.table, args.force) as partial:
        partial.write_text("degree\terror_percent\tpower\n" + "".join(lines))
