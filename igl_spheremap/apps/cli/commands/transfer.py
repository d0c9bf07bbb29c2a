"""Carry data over a mapped surface to another one, or to an icosphere.

    igl-spheremap transfer lh.pial lh.sphere.conformal lh_thickness.shape.gii --data lh.thickness --to ico:5
    igl-spheremap transfer a.ply a_sphere.ply b_parcels.npz --data parcels.npz --labels --to b_sphere.ply
"""

from __future__ import annotations

from argparse import Namespace

from ....io import write_scalars
from ....shapes.locate import SphereLocator
from ....shapes.transfer import interpolate
from ..output import Findings
from ..pair import load_pair
from ..streams import check_outputs
from ..vertex_data import read_maps, read_target_sphere


def run(args: Namespace) -> None:
    """Locate the target's vertices on the source's map, and interpolate; the two maps must share a frame."""
    check_outputs(args)
    points, _ = read_target_sphere(args)
    pair = load_pair(args)
    source = pair.source
    maps = read_maps(args.data, len(source.v), source.name)
    args.progress.stage(f"locating {len(points)} points on {pair.name}")
    location = SphereLocator(pair.unit, source.f).locate(points)
    carried = {key: interpolate(values, source.f, location, args.labels) for key, values in maps.items()}
    write_scalars(args.target, carried, force=args.force, metadata=source.metadata)
    found = Findings(target=args.target, vertices=len(points), maps={})
    found.mesh("source", source)
    found.add("sphere", f"{pair.name}, at the {len(points)} vertices of {args.to}", sphere=pair.name, to=args.to)
    for key, values in carried.items():
        low, high = found.figures["maps"][key] = float(values.min()), float(values.max())
        found.add("written", f"{args.target}: {key}, {low:.4g} to {high:.4g}")
    found.report(args)
