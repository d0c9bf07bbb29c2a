"""Remesh a surface with the connectivity of a regular sphere, or of another map.

    igl-spheremap resample lh.pial lh.sphere.conformal lh_ico5.surf.gii --to ico:5
    igl-spheremap resample sub01.ply sub01_sphere.ply sub01_on_sub02.ply --to sub02_sphere.ply
"""

from __future__ import annotations

from argparse import Namespace

from ....io import write_mesh
from ....shapes.locate import SphereLocator
from ....shapes.transfer import interpolate
from ..output import Findings, mesh_size
from ..pair import load_pair
from ..streams import check_outputs, target_format, write_target
from ..vertex_data import read_target_sphere


def run(args: Namespace) -> None:
    """Locate the new vertices on the map, and interpolate; a map that folds is an error, Exit.UNCERTIFIED."""
    check_outputs(args, surface=True)
    points, faces = read_target_sphere(args)
    pair = load_pair(args)
    source = pair.source
    args.progress.stage(f"resampling {source.name}")
    v = interpolate(source.v, source.f, SphereLocator(pair.unit, source.f).locate(points))
    write_target(args, lambda path: write_mesh(path, v, faces, force=args.force, metadata=source.metadata))
    found = Findings(target=args.target, vertices=len(v), faces=len(faces))
    found.mesh("source", source)
    found.add("sphere", f"{pair.name}, resampled at the vertices of {args.to}", sphere=pair.name, to=args.to)
    found.add("written", mesh_size(f"{args.target} ({target_format(args).name})", v, faces))
    found.report(args)
