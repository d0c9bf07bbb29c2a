"""A helical spring: a long tube, whose ends a conformal map shrinks beyond what float64 can hold."""

from __future__ import annotations

import numpy as np

from ..errors import own_errstate
from ..mesh.arrays import FloatArray, IntArray
from .arguments import number
from .rings import loft

TUBE = 0.22  # radius of the tube, where that of the coil is 1
PITCH = 0.8  # rise in one turn


@own_errstate
def spring(n_vertices: int = 9000, turns: float = 5.0) -> tuple[FloatArray, IntArray]:
    """Tube along a helix of radius 1 about the z axis, closed by round ends.

    Parameters
    ----------
    n_vertices : int
        Approximate number of vertices.
    turns : float
        Number of turns of the helix; each is 4.6 circumferences of the tube long.

    Returns
    -------
    v : (n, 3) float64 ndarray
    f : (m, 3) int64 ndarray
    """
    number("turns", turns, least=0.1, most=100)
    number("n_vertices", n_vertices, least=100 + 60 * turns)
    length = turns * np.hypot(2.0 * np.pi, PITCH)
    quarter = 0.5 * np.pi * TUBE

    def from_end(s: FloatArray) -> FloatArray:
        return np.minimum(np.minimum(s, length + 2.0 * quarter - s), quarter)

    s, angle, f = loft(lambda s: TUBE * np.sin(from_end(s) / TUBE), length + 2.0 * quarter, n_vertices)
    across = TUBE * np.sin(from_end(s) / TUBE)
    beyond = TUBE * np.cos(from_end(s) / TUBE) * np.sign(s - quarter - 0.5 * length)
    return _bend(np.clip(s - quarter, 0.0, length), beyond, across, angle), f


def _bend(s: FloatArray, beyond: FloatArray, across: FloatArray, angle: FloatArray) -> FloatArray:
    """Points at a distance and angle across the helix at arc length s, moved ``beyond`` along its tangent.

    Angles are from a frame that does not turn about the tangent (the normal and binormal turn by the
    torsion), so that triangles are not sheared.
    """
    unit = np.hypot(2.0 * np.pi, PITCH)
    turn, rise = 2.0 * np.pi / unit, PITCH / unit
    zero = np.zeros_like(s)
    cos, sin = np.cos(turn * s), np.sin(turn * s)
    centre = np.stack([cos, sin, rise * s], axis=1)
    tangent = np.stack([-turn * sin, turn * cos, rise + zero], axis=1)
    normal = np.stack([-cos, -sin, zero], axis=1)
    binormal = np.stack([rise * sin, -rise * cos, turn + zero], axis=1)
    angle = angle - turn * rise * s
    return (
        centre
        + beyond[:, None] * tangent
        + (across * np.cos(angle))[:, None] * normal
        + (across * np.sin(angle))[:, None] * binormal
    )
