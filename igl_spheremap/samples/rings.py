"""Meshes lofted through rings of vertices, from pole to pole; the helical spring is one.

A spring is a long tube, whose ends a conformal map shrinks beyond float64.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..errors import check_number
from ..gate import gate
from ..mesh.arrays import FloatArray, IntArray
from .icosphere import MOST_VERTICES


@gate
def spring(n_vertices: int = 9000, turns: float = 5.0) -> tuple[FloatArray, IntArray]:
    """Tube of radius .22 along a helix of radius 1 about the z axis, which rises by .8 in a turn, closed by round ends.

    `n_vertices` and the result are those of every sample, see `igl_spheremap.samples`.

    Parameters
    ----------
    turns : float
        Number of turns of the helix, 0.1 to 100; each is 4.6 circumferences of the tube long.
    """
    check_number(turns, "turns", 0.1, 100)
    # 18 rings of 3 vertices a turn
    check_number(n_vertices, "n_vertices", 100 + 60 * turns, MOST_VERTICES)
    tube, pitch = 0.22, 0.8
    length = turns * np.hypot(2.0 * np.pi, pitch)
    quarter = 0.5 * np.pi * tube

    def from_end(s: FloatArray) -> FloatArray:
        return np.minimum(np.minimum(s, length + 2.0 * quarter - s), quarter)

    s, angle, f = loft(
        lambda s: tube * np.sin(from_end(s) / tube), length + 2.0 * quarter, n_vertices
    )
    across = tube * np.sin(from_end(s) / tube)
    beyond = tube * np.cos(from_end(s) / tube) * np.sign(s - quarter - 0.5 * length)
    return _bend(pitch, np.clip(s - quarter, 0.0, length), beyond, across, angle), f


def _bend(
    pitch: float, s: FloatArray, beyond: FloatArray, across: FloatArray, angle: FloatArray
) -> FloatArray:
    """Points at a distance and angle across the helix at arc length s, moved ``beyond`` along its tangent.

    Angles are from a frame that does not turn about the tangent (the normal and binormal turn by the
    torsion), so that triangles are not sheared.
    """
    unit = np.hypot(2.0 * np.pi, pitch)
    turn, rise = 2.0 * np.pi / unit, pitch / unit
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


def loft(
    radius: Callable[[FloatArray], FloatArray], length: float, n_vertices: int
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Arc length and angle (radians) of each vertex, and faces, of a closed mesh swept by circles about an axis.

    `radius` gives that of the circle at arc lengths of the profile, which runs from pole to pole with radius 0 at both
    ends. Faces are counterclockwise seen from outside if the arc length grows along the axis that angles turn around.
    """
    counts = _ring_counts(radius, length, n_vertices)
    ring = np.repeat(np.arange(len(counts)), counts)
    first = np.cumsum(counts) - counts
    index = np.arange(len(ring)) - first[ring]
    angle = 2.0 * np.pi * (index + 0.5 * (ring % 2)) / counts[ring]
    faces = [
        _stitch(j, counts[j], counts[j + 1], first[j], first[j + 1]) for j in range(len(counts) - 1)
    ]
    return length * ring / (len(counts) - 1), angle, np.concatenate(faces)


def _ring_counts(
    radius: Callable[[FloatArray], FloatArray], length: float, n_vertices: int
) -> IntArray:
    """Vertices on each ring: 1 at the poles, elsewhere a number that makes triangles near-equilateral."""
    s = np.linspace(0.0, length, 2001)
    area = 2.0 * np.pi * length * np.mean(radius(s))
    edge = np.sqrt(area / (np.sqrt(0.75) * n_vertices))
    rings = max(round(length / (np.sqrt(0.75) * edge)), 2)
    circles = 2.0 * np.pi * radius(length * np.arange(1, rings) / rings)
    counts = np.maximum(np.round(circles * (n_vertices - 2) / circles.sum()).astype(np.int64), 3)
    return np.concatenate([[1], counts, [1]])


def _stitch(j: int, k: int, m: int, first: int, second: int) -> IntArray:
    """Triangles between ring j of k vertices and the next of m: each edge takes the nearest vertex opposite.

    Angles are compared in whole numbers, in units of a (2 k m)-th of a turn, so that a tie goes the same way
    from both sides.
    """
    odd, even = j % 2, (j + 1) % 2  # every other ring is turned by half an edge
    faces = []
    if k > 1:
        i = np.arange(k)
        apex = -((k * even + k - m * (2 * i + 1 + odd)) // (2 * k))
        faces.append(np.stack([first + i, first + (i + 1) % k, second + apex % m], axis=1))
    if m > 1:
        i = np.arange(m)
        apex = (k * (2 * i + 1 + even) - m * odd + m) // (2 * m)
        faces.append(np.stack([second + (i + 1) % m, second + i, first + apex % k], axis=1))
    return np.concatenate(faces)
