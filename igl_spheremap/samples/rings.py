"""Meshes lofted through rings of vertices, from pole to pole, with near-equilateral triangles."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..mesh.arrays import FloatArray, IntArray


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
    faces = [_stitch(j, counts[j], counts[j + 1], first[j], first[j + 1]) for j in range(len(counts) - 1)]
    return length * ring / (len(counts) - 1), angle, np.concatenate(faces)


def _ring_counts(radius: Callable[[FloatArray], FloatArray], length: float, n_vertices: int) -> IntArray:
    """Vertices on each ring: 1 at the poles, elsewhere as many as make triangles near-equilateral."""
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
        apex = -((k * even + k - m * (2 * i + 1 + odd)) // (2 * k)) if m > 1 else 0 * i
        faces.append(np.stack([first + i, first + (i + 1) % k, second + apex % m], axis=1))
    if m > 1:
        i = np.arange(m)
        apex = (k * (2 * i + 1 + even) - m * odd + m) // (2 * m) if k > 1 else 0 * i
        faces.append(np.stack([second + (i + 1) % m, second + i, first + apex % k], axis=1))
    return np.concatenate(faces)
