"""Maps to the plane: exact orientation of faces, and whether the boundary of the image crosses itself."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..mesh.arrays import BoolArray, FloatArray, IntArray
from .signs import orientation_signs

#: Pairs of rim edges whose bounding boxes are compared at once.
_BLOCK = 1 << 20


def plane_signs(p: FloatArray, f: IntArray) -> IntArray:
    """Orientation of each face in the plane: +1 counterclockwise, -1 clockwise, 0 if it is flat; exact.

    >>> plane_signs(np.array([[0.0, 0], [1, 0], [0, 1]]), np.array([[0, 1, 2], [0, 2, 1], [0, 1, 1]]))
    array([ 1, -1,  0])
    """
    return orientation_signs(np.column_stack((p, np.ones(len(p)))), f)


def rim_crossings(p: FloatArray, rim: IntArray) -> BoolArray:
    """Which edges of a closed polygon meet others, apart from shared corners; edge i begins at rim[i]; exact.

    >>> p = np.array([[0.0, 0], [2, 0], [2, 2], [0, 2], [0.0, 1], [3, 1], [0, 0.5]])
    >>> rim_crossings(p, np.arange(7))
    array([False,  True, False, False,  True,  True, False])
    """
    k, q = len(rim), p[rim]
    meets = np.zeros(k, dtype=bool)
    # Neighbours overlap where the polygon turns back on itself: then their other ends lie on one ray.
    ends = np.column_stack((np.roll(np.arange(k), 1), np.arange(k), np.roll(np.arange(k), -1)))
    before, after = q[ends[:, 0]] - q, q[ends[:, 2]] - q
    back = (plane_signs(q, ends) == 0) & (np.sign(before) == np.sign(after)).all(axis=1)
    meets[back] = meets[ends[back, 0]] = True
    for i, j in _close_pairs(q):
        a, b, c, d = i, (i + 1) % k, j, (j + 1) % k
        s = [plane_signs(q, np.column_stack(corners)) for corners in ((a, b, c), (a, b, d), (c, d, a), (c, d, b))]
        hit = (s[0] * s[1] <= 0) & (s[2] * s[3] <= 0)  # on one line, too: there their boxes overlap
        meets[i[hit]] = meets[j[hit]] = True
    return meets


def rim_direction(p: FloatArray, rim: IntArray) -> int:
    """+1 if a closed polygon that meets itself nowhere runs counterclockwise, else -1; exact."""
    k = np.lexsort((p[rim, 1], p[rim, 0]))[0]  # the leftmost corner is convex
    return int(plane_signs(p, rim[[k - 1, k, (k + 1) % len(rim)]][None])[0])


def _close_pairs(q: FloatArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Pairs of edges of a closed polygon, neighbours left out, whose bounding boxes meet; in blocks."""
    k, r = len(q), np.roll(q, -1, axis=0)
    low, high = np.minimum(q, r), np.maximum(q, r)
    sweeps = []
    for axis in (0, 1):
        order = np.argsort(low[:, axis], kind="stable")
        last = np.searchsorted(low[order, axis], high[order, axis], side="right")
        sweeps.append((int(last.sum()), axis, order, last - np.arange(k) - 1))
    _, axis, order, ahead = min(sweeps, key=lambda sweep: sweep[0])  # along which fewer edges lie side by side
    begins = np.cumsum(ahead) - ahead
    for first in range(0, int(ahead.sum()), _BLOCK):
        place = np.arange(first, min(first + _BLOCK, int(ahead.sum())))
        left = np.searchsorted(begins + ahead, place, side="right")
        i, j = order[left], order[left + 1 + place - begins[left]]
        other = 1 - axis
        gap = np.abs(i - j)
        near = (low[i, other] <= high[j, other]) & (low[j, other] <= high[i, other]) & (gap > 1) & (gap < k - 1)
        if near.any():
            yield i[near], j[near]
