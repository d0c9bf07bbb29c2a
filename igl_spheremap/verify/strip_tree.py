"""Pairs of edges of a polygon that may meet, by rectangles around runs of edges.

Each run of 1, 4, 16, ... consecutive edges has a rectangle along the line that is nearest to its edges, since the chord
of a jagged run may lie across it. If the rectangles of two runs are apart, none of their edges meet; else the quarters
of both runs are compared. So the number of pairs compared is little above the number of edges, even for the spikes of a
star: long thin parts side by side, whose bounding boxes nearly all meet.

Ballard 1981, *Strip Trees: A Hierarchical Representation for Curves*.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from ..mesh.arrays import EPS, ComplexArray, FloatArray, IntArray, own_unit


def close_pairs(
    p: FloatArray, longest: int = 128, parts: int = 4, block: int = 1 << 17
) -> Iterator[tuple[IntArray, IntArray]]:
    """Pairs i < j of edges of a closed polygon that may meet, neighbours left out, in blocks; edge i begins at p[i].

    The comparison begins with runs that number at most `longest`: all their 8,256 pairs, in one call. Each has four
    `parts`: with halves the rectangles of small polygons take longer than all comparisons. A `block` of pairs is
    compared at once, so that temporaries take some megabytes.

    >>> zigzag = np.array([[0.0, 0], [9, 1], [0, 2], [9, 3], [0, 4], [9, 5], [-1, 6], [-1, -1]])
    >>> sum(len(i) for i, j in close_pairs(zigzag))
    0
    """
    k = len(p)
    height = max(0, int(np.ceil(np.log(k / longest) / np.log(parts))))
    x, y = own_unit(p)[0].T
    z = x + 1j * y
    levels = [_Runs(p, z, parts**h) for h in range(height + 1)]
    waiting = [(height, *np.triu_indices(levels[height].count))]
    one, other = np.indices((parts, parts)).reshape(2, -1)
    while waiting:
        h, i, j = waiting.pop()
        if h == 0:
            apart = (j - i > 1) & (j - i < k - 1)
            i, j = levels[h].near(i[apart], j[apart])
            if len(i):
                yield i, j
            continue
        i, j = levels[h].near(i, j)
        i, j = (parts * i[:, None] + one).ravel(), (parts * j[:, None] + other).ravel()
        kept = (i <= j) & (j < levels[h - 1].count)
        i, j = i[kept], j[kept]
        waiting += [(h - 1, i[n : n + block], j[n : n + block]) for n in range(0, len(i), block)]


class _Runs:
    """Runs of equally many edges of a closed polygon; the last one has the rest.

    Parameters
    ----------
    p : (k, 2) float64 array
        The polygon.
    z : (k,) complex128 array
        The polygon in its own unit.
    length : int
        Edges of a run.
    """

    def __init__(self, p: FloatArray, z: ComplexArray, length: int) -> None:
        self._first, self._z, self._after = np.arange(0, len(p), length), z, np.append(z[1:], z[0])
        self._run = np.arange(len(p)) // length
        self.count, self._met = len(self._first), 0
        # Bounding boxes, of the coordinates as they were given: comparing them is exact.
        ends = p.T, np.append(p[1:], p[:1], axis=0).T
        self._low, self._high = (
            extreme.reduceat(extreme(*ends), self._first, axis=1)
            for extreme in (np.minimum, np.maximum)
        )

    def near(self, i: IntArray, j: IntArray) -> tuple[IntArray, IntArray]:
        """The pairs whose bounding boxes meet; if they are many, only those whose rectangles no side separates.

        A run meets itself and the next one on any polygon, and one or two more on most.
        """
        meet = (self._low.take(i, axis=1) <= self._high.take(j, axis=1)).all(axis=0)
        meet &= (self._low.take(j, axis=1) <= self._high.take(i, axis=1)).all(axis=0)
        i, j = i[meet], j[meet]
        self._met += len(i)
        if self._met <= 3 * self.count:
            return i, j
        centre, along, sides, error = self._rectangles
        between, turn, error = (
            centre[j] - centre[i],
            along[j] * along[i].conj(),
            error[i] + error[j],
        )
        cos, sin, meet = np.abs(turn.real), np.abs(turn.imag), np.ones(len(i), dtype=bool)
        for one, other in ((i, j), (j, i)):
            seen, (long, wide), (a, b) = between * along[one].conj(), sides[:, one], sides[:, other]
            meet &= np.abs(seen.real) <= long + a * cos + b * sin + error
            meet &= np.abs(seen.imag) <= wide + a * sin + b * cos + error
        return i[meet], j[meet]

    @cached_property
    def _rectangles(self) -> tuple[ComplexArray, ComplexArray, FloatArray, FloatArray]:
        """Centres, unit vectors of the first sides, halves of the sides (2, runs), and bounds on their rounding."""
        z, after, first, run = self._z, self._after, self._first, self._run
        start, axis = z[first], np.sqrt(np.add.reduceat((after - z) ** 2, first))
        along = np.where(axis == 0, 1.0, axis / np.where(axis == 0, 1.0, np.abs(axis)))
        one, other = ((each - start[run]) * along.conj()[run] for each in (z, after))
        (left, under), (right, above) = (
            [
                extreme.reduceat(extreme(a, b), first)
                for a, b in ((one.real, other.real), (one.imag, other.imag))
            ]
            for extreme in (np.minimum, np.maximum)
        )
        size = np.maximum.reduceat(np.maximum(np.abs(z), np.abs(after)), first)
        return (
            start + along * ((left + right) / 2 + 0.5j * (under + above)),
            along,
            np.stack((right - left, above - under)) / 2,
            64 * EPS * size,  # some twenty roundings, and room
        )
