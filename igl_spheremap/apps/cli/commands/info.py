"""`igl-spheremap info IN`: measure a mesh."""

from __future__ import annotations

import math
from argparse import Namespace
from dataclasses import asdict
from typing import Any

from ....mesh.check import Mesh, check_mesh
from ....mesh.quality import MeshQuality, mesh_quality
from ....operators.limb_scale import FLOAT64_LIMIT, Limb, deep_limbs, log_scale, shortest_image_edges
from ....operators.operators import build_operators
from ..output import report, row
from ..source import Source, load_source
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
    figures: dict[str, Any] = {
        "source": source.name,
        "repairs": source.repairs,
        "vertices": len(mesh.v),
        "edges": len(mesh.f) * 3 // 2,
        "faces": len(mesh.f),
        "genus": 0,
        "components": 1,
        **asdict(quality),
        "weights": operators.weights,
        "notes": operators.notes,
        "shortest_image_edge": shortest,
        "deep_limbs": [asdict(limb) | {"position": mesh.vertices[limb.tip]} for limb in limbs],
    }
    report(args, figures, _summary(source, mesh, quality, shortest, limbs))


def _summary(
    source: Source, mesh: Mesh, quality: MeshQuality, shortest: float, limbs: tuple[Limb, ...]
) -> list[str]:
    m = len(mesh.f)
    return [
        row("mesh", f"{source.name}: {len(mesh.v)} vertices, {m * 3 // 2} edges, {m} faces"),
        row("topology", "closed, oriented, connected, genus 0: it can be mapped"),
        row(
            "size",
            f"{' x '.join(f'{side:.4g}' for side in quality.extent)}, area {quality.area:.4g}, "
            f"volume {abs(quality.volume):.4g}{' (oriented inwards)' * (quality.volume < 0)}",
        ),
        row(
            "edges",
            f"{quality.shortest_edge:.3g} to {quality.longest_edge:.3g}, mean {quality.mean_edge:.3g}; "
            f"at most {quality.largest_valence} at a vertex",
        ),
        row(
            "angles",
            f"{quality.smallest_angle:.3g} to {quality.largest_angle:.4g} degrees; "
            f"{quality.slivers} slivers below 1 degree, {quality.zero_area_faces} faces of zero area, "
            f"{quality.coincident_vertices} coincident vertices",
        ),
        row(
            "weights",
            f"{quality.non_delaunay_edges} of {m * 3 // 2} edges are not Delaunay: "
            "negative weights there",
        ),
        row("limbs", _limbs(mesh, shortest, limbs)),
    ]


def _limbs(mesh: Mesh, shortest: float, limbs: tuple[Limb, ...]) -> str:
    predicted = (
        f"predicted shortest image edge: 1e{math.floor(math.log10(shortest))}"
        if shortest > 0
        else "below 1e-308"
    )
    if not limbs:
        return f"none that float64 can't hold; {predicted}"
    where = "; ".join(
        "{} vertices at vertex {} ({:.4g}, {:.4g}, {:.4g})".format(
            limb.vertices, limb.tip, *mesh.vertices[limb.tip]
        )
        for limb in limbs[:_SHOWN]
    )
    more = f"; and {len(limbs) - _SHOWN} more" if len(limbs) > _SHOWN else ""
    return f"{len(limbs)} shrink below {FLOAT64_LIMIT:.0e}, where float64 ends: {where}{more}; {predicted}"
