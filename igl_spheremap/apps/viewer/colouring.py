"""What the colours of a surface tell: foldings, conformal factor, angle differences."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ...mesh.check import Mesh
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
FOLDED_LEGEND = ("folded face", style.FOLDED)
_DARKEST = 0.72
_U = "log conformal factor u (purple: shrunk)"
_ANGLES = "angle difference in degrees"


@dataclass(frozen=True, eq=False)
class Colouring:
    """Colours of the faces and what they mean.

    Attributes
    ----------
    colours : (m, 3) float64 array
        As they shall look.
    folded : int64 array
        Faces that are flipped or degenerate; they are painted over.
    legend : Ramp or (str, colour)
        Their meaning.
    """

    colours: FloatArray
    folded: IntArray
    legend: Legend

    def apply(self, *bodies: Body) -> None:
        """Paint bodies.

        Parameters
        ----------
        *bodies : Body
            With the faces of the map.

        Returns
        -------
        None
        """
        for body in bodies:
            body.paint(self.colours, self.folded)
            body.legend = self.legend


def folded_faces(mesh: Mesh, x: FloatArray) -> IntArray:
    """Faces whose image is flipped or degenerate.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    x : (n, 3) float64 array
        A map to the unit sphere.

    Returns
    -------
    int64 array
        Indices.
    """
    return np.flatnonzero(orientation_signs(np.ascontiguousarray(x), mesh.f) <= 0)


def log_factor(mesh: Mesh, x: FloatArray) -> FloatArray:
    """u of the conformal factor e^{2u}, eq. (14), with 0 at the scale that takes unit area to the sphere's.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    x : (n, 3) float64 array
        A map to the unit sphere.

    Returns
    -------
    (n,) float64 array
        Finite.
    """
    return np.asarray(0.5 * np.log(finite_conformal_factor(mesh, x) / (4 * math.pi)))  # eq. (14)


@lru_cache(maxsize=4)
def relief(mesh: Mesh) -> FloatArray:
    """Brightness of the faces, hollows being darker: so the image shows what is where, as atlases of the cortex do.

    Parameters
    ----------
    mesh : Mesh
        The checked source.

    Returns
    -------
    (m,) float64 array
        Between `_DARKEST` and 1.
    """
    tail, head = mesh.f[:, [0, 1, 2]].ravel(), mesh.f[:, [1, 2, 0]].ravel()  # every edge, once each way
    valence = np.bincount(tail, minlength=len(mesh.v))
    mean = np.column_stack([np.bincount(tail, mesh.v[head, k], len(mesh.v)) for k in range(3)]) / valence[:, None]
    a, b, c = (mesh.v[mesh.f[:, k]] for k in range(3))
    outward = 1 if np.einsum("ij,ij->", a, np.cross(b, c)) >= 0 else -1  # the sign of the volume
    hollow = outward * np.einsum("ij,ij->i", mean - mesh.v, mesh_gauss_map(mesh))[mesh.f].mean(axis=1)
    scale = float(np.percentile(np.abs(hollow), 80)) or 1.0
    return np.asarray(1 - (1 - _DARKEST) * np.clip(0.5 + 0.5 * hollow / scale, 0, 1))


def colouring(mesh: Mesh, x: FloatArray, subject: str, reach: float | None = None) -> Colouring:
    """Colours that show a subject.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    x : (n, 3) float64 array
        A map to the unit sphere.
    subject : str
        One of `SUBJECTS`.
    reach : float, optional
        Value at the end of the colours; chosen from the map by default.

    Returns
    -------
    Colouring
        For source and image alike.
    """
    folded = folded_faces(mesh, x)
    if subject == "foldings":
        return Colouring(relief(mesh)[:, None] * style.SURFACE, folded, FOLDED_LEGEND)
    if subject == "conformal factor":
        u = log_factor(mesh, x)
        ramp = style.diverging(_U, reach or style.round_up(float(u.max())))
        values = u[mesh.f].mean(axis=1)
    else:
        values = np.abs(mesh_angle_differences(mesh, x)).mean(axis=1)
        ramp = style.sequential(_ANGLES, 0, reach or style.round_up(float(np.percentile(values, 95))))
    return Colouring(ramp.colours(values), folded, ramp)
