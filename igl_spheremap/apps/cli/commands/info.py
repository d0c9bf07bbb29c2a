"""Measure a mesh: size, triangle quality, and limbs that float64 can't resolve on the sphere.

    igl-spheremap info sample:octopus
    igl-spheremap info lh.pial --json -
"""

from __future__ import annotations

import math
from argparse import Namespace
from dataclasses import asdict

from ....mesh.check import Mesh, check_mesh
from ....mesh.quality import MeshQuality, mesh_quality
from ....operators.limb_scale import FLOAT64_LIMIT, Limb, deep_limbs, log_scale, shortest_image_edges
from ....operators.operators import build_operators
from ..output import Findings
from ..source import load_source
from ..streams import check_outputs

_SHOWN = 3  # limbs that the summary names


def run(args: Namespace) -> None:
    """Measure a mesh."""
    check_outputs(args)
    source = load_source(args)
    args.progress.stage(f"measuring {source.name}")
    mesh = check_mesh(source.v, source.f)
    quality = mesh_quality(mesh)
    operators = build_operators(mesh)
    scale = log_scale(mesh, operators)
    limbs = deep_limbs(mesh, scale)
    shortest = float(shortest_image_edges(mesh, scale).min())
    found = Findings(genus=0, components=1, weights=operators.weights, notes=operators.notes, **asdict(quality))
    found.source(source)
    _describe(found, quality, len(mesh.f) * 3 // 2)
    found.add("limbs", _limbs(mesh, shortest, limbs), shortest_image_edge=shortest,
              deep_limbs=[asdict(limb) | {"position": mesh.vertices[limb.tip]} for limb in limbs])
    found.report(args)


def _describe(found: Findings, quality: MeshQuality, edges: int) -> None:
    """The summary of a mesh's quality."""
    found.add("topology", "closed, oriented, connected, genus 0: it can be mapped")
    found.add(
        "size",
        f"{' x '.join(f'{side:.4g}' for side in quality.extent)}, area {quality.area:.4g}, "
        f"volume {abs(quality.volume):.4g}{' (oriented inwards)' * (quality.volume < 0)}",
    )
    found.add(
        "edges",
        f"{edges}, {quality.shortest_edge:.3g} to {quality.longest_edge:.3g} long, mean {quality.mean_edge:.3g}; "
        f"at most {quality.largest_valence} at a vertex",
        edges=edges,
    )
    found.add(
        "angles",
        f"{quality.smallest_angle:.3g} to {quality.largest_angle:.4g} degrees; "
        f"{quality.slivers} slivers below 1 degree, {quality.zero_area_faces} faces of zero area, "
        f"{quality.coincident_vertices} coincident vertices",
    )
    found.add("weights", f"{quality.non_delaunay_edges} of {edges} edges are not Delaunay: negative weights there")


def _limbs(mesh: Mesh, shortest: float, limbs: tuple[Limb, ...]) -> str:
    power = f"1e{math.floor(math.log10(shortest))}" if shortest > 0 else "below 1e-308"
    predicted = f"predicted shortest image edge: {power}"
    if not limbs:
        return f"none that float64 can't hold; {predicted}"
    tips = "{} vertices at vertex {} ({:.4g}, {:.4g}, {:.4g})"
    where = "; ".join(tips.format(limb.vertices, limb.tip, *mesh.vertices[limb.tip]) for limb in limbs[:_SHOWN])
    more = f"; and {len(limbs) - _SHOWN} more" if len(limbs) > _SHOWN else ""
    return f"{len(limbs)} shrink below {FLOAT64_LIMIT:.0e}, where float64 ends: {where}{more}; {predicted}"
