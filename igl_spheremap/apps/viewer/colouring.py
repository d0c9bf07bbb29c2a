"""What the colours of a surface show: foldings and places, conformal factor, angle differences."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix, diags_array

from ...mesh.check import Mesh
from ...mesh.measure import face_areas
from ...mesh.normals import mesh_gauss_map
from ...start.star_map import finite_conformal_factor
from ...verify.certificate import orientation_signs
from ...verify.distortion import mesh_angle_differences
from . import style
from .body import Body, Legend

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: What can be shown, in the order of the menus.
SUBJECTS = ("foldings", "conformal factor", "angle differences")
FOLDED_LEGEND = ("folded face; same colour: same place", style.FOLDED)
_DARKEST = 0.72
#: A hollow is measured within so many edges of a vertex, as a share of the root of the number of vertices.
_REACH = 0.05
_U = "log conformal factor u (purple: shrunk)"
_ANGLES = "angle difference in degrees"


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


def folded_faces(mesh: Mesh, x: FloatArray) -> IntArray:
    """Indices of the faces whose image is flipped or degenerate."""
    return np.flatnonzero(orientation_signs(np.ascontiguousarray(x), mesh.f) <= 0)


def log_factor(mesh: Mesh, x: FloatArray) -> FloatArray:
    """u of the conformal factor e^{2u}, eq. (14), with 0 at the scale that takes unit area to the sphere's."""
    return np.asarray(0.5 * np.log(finite_conformal_factor(mesh, x) / (4 * math.pi)))  # eq. (14)


@lru_cache(maxsize=4)
def relief(mesh: Mesh) -> FloatArray:
    """Brightness of the faces, hollows being darker: so the image shows what is where, as atlases of the cortex do."""
    tail, head = mesh.f[:, [0, 1, 2]].ravel(), mesh.f[:, [1, 2, 0]].ravel()  # every edge, once each way
    links = csr_matrix((np.ones(len(tail)), (tail, head)), shape=(len(mesh.v), len(mesh.v)))
    average = diags_array(1 / np.bincount(tail, minlength=len(mesh.v))) @ links
    mean = mesh.v
    for _ in range(1 + int(np.sqrt(len(mesh.v)) * _REACH)):
        mean = average @ mean
    a, b, c = (mesh.v[mesh.f[:, k]] for k in range(3))
    outward = 1 if np.einsum("ij,ij->", a, np.cross(b, c)) >= 0 else -1  # the sign of the volume
    hollow = outward * np.einsum("ij,ij->i", mean - mesh.v, mesh_gauss_map(mesh))[mesh.f].mean(axis=1)
    scale = float(np.percentile(np.abs(hollow), 80)) or 1.0
    return np.asarray(1 - (1 - _DARKEST) * np.clip(0.5 + 0.5 * hollow / scale, 0, 1))


@lru_cache(maxsize=4)
def places(mesh: Mesh) -> FloatArray:
    """Colours by place on a surface: from end to end along its longest side, equal areas each."""
    side = int(np.argmax(np.ptp(mesh.v, axis=0)))
    order = np.argsort(mesh.v[mesh.f, side].mean(axis=1), kind="stable")
    rank = np.empty(len(mesh.f))
    rank[order] = np.cumsum(face_areas(mesh.v, mesh.f)[order])
    return style.sequential("", 0, float(rank.max())).colours(rank) * relief(mesh)[:, None]


def colouring(
    mesh: Mesh, x: FloatArray, subject: str, reach: float | None = None, folded: IntArray | None = None
) -> Colouring:
    """Colours of a subject for source and image alike.

    `reach` is the value at the end of the colours, chosen from the map by default; `folded` saves the time to
    find the folded faces.
    """
    folded = folded_faces(mesh, x) if folded is None else folded
    if subject == "foldings":
        return Colouring(places(mesh), folded, FOLDED_LEGEND)
    if subject == "conformal factor":
        u = log_factor(mesh, x)
        ramp = style.diverging(_U, reach or style.round_up(float(u.max())))
        values = u[mesh.f].mean(axis=1)
    else:
        values = np.abs(mesh_angle_differences(mesh, x)).mean(axis=1)
        ramp = style.sequential(_ANGLES, 0, reach or style.round_up(float(np.percentile(values, 95))))
    return Colouring(ramp.colours(values), folded, ramp)
