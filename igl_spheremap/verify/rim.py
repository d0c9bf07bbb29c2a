"""Maps to the plane: exact orientation of faces, and whether the boundary of the image crosses itself."""

from __future__ import annotations

import numpy as np

from ..mesh.arrays import BoolArray, FloatArray, IntArray
from .signs import orientation_signs
from .strip_tree import close_pairs


def plane_signs(p: FloatArray, f: IntArray) -> IntArray:
    """Orientation of each face in the plane: +1 counterclockwise, -1 clockwise, 0 if it is flat; exact.

    >>> plane_signs(np.array([[0.0, 0], [1, 0], [0, 1]]), np.array([[0, 1, 2], [0, 2, 1], [0, 1, 1]]))
    array([ 1, -1,  0])
    """
    return orientation_signs(np.column_stack((p, np.ones(len(p)))), f)


def rim_crossings(p: FloatArray, rim: IntArray) -> BoolArray:
    """Whether each edge of a closed polygon meets others, apart from shared corners; edge i begins at rim[i]; exact.

    >>> p = np.array([[0.0, 0], [2, 0], [2, 2], [0, 2], [0.0, 1], [3, 1], [0, 0.5]])
    >>> rim_crossings(p, np.arange(7))
    array([False,  True, False, False,  True,  True, False])
    """
    meets = np.zeros(len(rim), dtype=bool)
    meets[rim_meetings(p, rim)] = True
    return meets


def rim_meetings(p: FloatArray, rim: IntArray) -> IntArray:
    """The pairs (m, 2) of edges of a closed polygon that meet, apart from shared corners; exact."""
    k, q = len(rim), p[rim]
    # If the polygon turns back on itself, neighbours overlap: their other ends lie on one ray.
    ends = np.column_stack((np.roll(np.arange(k), 1), np.arange(k), np.roll(np.arange(k), -1)))
    before, after = q[ends[:, 0]] - q, q[ends[:, 2]] - q
    back = (plane_signs(q, ends) == 0) & (np.sign(before) == np.sign(after)).all(axis=1)
    meetings = [ends[back, :2]]
    for i, j in close_pairs(q):
        a, b, c, d = i, (i + 1) % k, j, (j + 1) % k
        s = [
            plane_signs(q, np.column_stack(corners))
            for corners in ((a, b, c), (a, b, d), (c, d, a), (c, d, b))
        ]
        hit = (s[0] * s[1] <= 0) & (s[2] * s[3] <= 0)  # on one line, too: there their boxes overlap
        meetings.append(np.column_stack((i[hit], j[hit])))
    return np.concatenate(meetings)


def rim_direction(p: FloatArray, rim: IntArray) -> int:
    """+1 if a closed polygon that meets itself nowhere runs counterclockwise, else -1; exact."""
    k = np.lexsort((p[rim, 1], p[rim, 0]))[0]  # the leftmost corner is convex
    return int(plane_signs(p, rim[[k - 1, k, (k + 1) % len(rim)]][None])[0])
