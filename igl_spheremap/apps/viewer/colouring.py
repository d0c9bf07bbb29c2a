"""What the colours of a surface show: foldings and places, conformal factor, distortion of angles and areas."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ...draw import palette
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import Mesh
from ...mesh.measure import face_areas
from ...shapes.features import FeatureSurface
from ...start.star_map import finite_conformal_factor
from ...verify.distortion import mesh_angle_differences, mesh_area_distortion
from ...verify.signs import folded_faces
from .body import Body, Legend
from .choices import SUBJECTS

FOLDED_LEGEND = ("folded face; same colour: same place", palette.FOLDED)
_DARKEST = 0.72
#: Hollows of about this size are seen, on a surface as large as the unit sphere.
_REACH = 0.1
_U = "log factor u (purple: shrunk)"
_ANGLES = "angle difference in degrees"
_AREAS = "log area ratio (purple: shrunk)"


@dataclass(frozen=True, eq=False)
class Colouring:
    """Colours of the faces, (m, 3), the faces that are painted over as folded, and the meaning."""

    colours: FloatArray
    folded: IntArray
    legend: Legend

    def apply(self, *bodies: Body) -> None:
        """Paint bodies with the faces of the map; the first bears the legend."""
        for body in bodies:
            body.paint(self.colours, self.folded)
            body.legend = self.legend if body is bodies[0] else None


def log_factor(mesh: Mesh, x: FloatArray) -> FloatArray:
    """u of the conformal factor e^{2u}, eq. (14), with 0 at the scale that takes unit area to the sphere's."""
    return np.asarray(0.5 * np.log(finite_conformal_factor(mesh, x) / (4 * math.pi)))  # eq. (14)


@lru_cache(maxsize=4)
def relief(mesh: Mesh) -> FloatArray:
    """Brightness of the faces, hollows being darker: so the image shows what is where, as atlases of the cortex do."""
    a, b, c = (mesh.v[mesh.f[:, k]] for k in range(3))
    outward = 1 if np.einsum("ij,ij->", a, np.cross(b, c)) >= 0 else -1  # the sign of the volume
    hollow = -outward * FeatureSurface(mesh).depth(_REACH)[mesh.f].mean(axis=1)
    scale = float(np.percentile(np.abs(hollow), 80)) or 1.0
    return np.asarray(1 - (1 - _DARKEST) * np.clip(0.5 + 0.5 * hollow / scale, 0, 1))


@lru_cache(maxsize=4)
def places(mesh: Mesh) -> FloatArray:
    """Colours by place on a surface: from end to end along its longest side, equal areas each."""
    side = int(np.argmax(np.ptp(mesh.v, axis=0)))
    order = np.argsort(mesh.v[mesh.f, side].mean(axis=1), kind="stable")
    rank = np.empty(len(mesh.f))
    rank[order] = np.cumsum(face_areas(mesh.v, mesh.f)[order])
    return palette.sequential("", 0, float(rank.max())).colours(rank) * relief(mesh)[:, None]


def colouring(
    mesh: Mesh, x: FloatArray, subject: str, reach: float | None = None, folded: IntArray | None = None
) -> Colouring:
    """Colours of a subject for source and image alike.

    `reach` is the value at the end of the colours, chosen from the map by default; `folded` saves the time to
    find the folded faces.
    """
    if subject not in SUBJECTS:
        raise ValueError(f"unknown subject {subject!r}: choose one of {', '.join(SUBJECTS)}")
    folded = np.flatnonzero(folded_faces(x, mesh.f)) if folded is None else folded
    if subject == "foldings":
        return Colouring(places(mesh), folded, FOLDED_LEGEND)
    if subject == "conformal factor":
        u = log_factor(mesh, x)
        ramp = palette.diverging(_U, reach or palette.round_up(float(u.max())))
        values = u[mesh.f].mean(axis=1)
    elif subject == "area distortion":
        values = mesh_area_distortion(mesh, x)
        finite = np.abs(values[np.isfinite(values)])
        ramp = palette.diverging(_AREAS, reach or palette.round_up(float(np.percentile(finite, 95))))
    else:
        values = np.abs(mesh_angle_differences(mesh, x)).mean(axis=1)
        ramp = palette.sequential(_ANGLES, 0, reach or palette.round_up(float(np.percentile(values, 95))))
    return Colouring(ramp.colours(values), folded, ramp)
