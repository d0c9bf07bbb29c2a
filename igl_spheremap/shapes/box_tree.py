"""A tree of boxes: which of many boxes hold a point, for many points at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_FAN = 4  # children of a node
_BITS = 21  # of each coordinate's rank in the order of the curve


class BoxTree:
    """Boxes in the order of a Morton curve through the ranks of their centres, and boxes around each four.

    Ranks make the curve blind to scale: where boxes crowd by twelve orders of magnitude the tree is no worse.

    Parameters
    ----------
    low, high : (m, 3) float64 arrays
        Corners of the boxes, at least one box.
    """

    def __init__(self, low: FloatArray, high: FloatArray) -> None:
        centre = (low + high) / 2
        self._sorted = np.sort(centre, axis=0)
        self._boxes = np.argsort(self._codes(centre), kind="stable")
        low, high = (np.ascontiguousarray(corner[self._boxes].T) for corner in (low, high))
        self._levels = [(low, high)]
        while low.shape[1] > 1:
            start = np.arange(0, low.shape[1], _FAN)
            low, high = np.minimum.reduceat(low, start, axis=1), np.maximum.reduceat(high, start, axis=1)
            self._levels.append((low, high))

    def order_of(self, points: FloatArray) -> IntArray:
        """An order of points in which neighbours are close.

        Parameters
        ----------
        points : (k, 3) float64 array
            Any.

        Returns
        -------
        (k,) int64 array
            A permutation.
        """
        return np.argsort(self._codes(points), kind="stable")

    def candidates(self, points: FloatArray) -> tuple[IntArray, IntArray]:
        """All pairs of a point and a box that holds it.

        Parameters
        ----------
        points : (k, 3) float64 array
            Any.

        Returns
        -------
        point, box : (p,) int64 arrays
            Rows of `points` and of the boxes that were given.
        """
        coordinates = np.ascontiguousarray(points.T)
        point, node = np.arange(len(points)), np.zeros(len(points), dtype=np.int64)
        point, node = self._inside(coordinates, point, node, len(self._levels) - 1)
        for level in range(len(self._levels) - 2, -1, -1):
            node = (_FAN * node[:, None] + np.arange(_FAN)).ravel()
            point = np.repeat(point, _FAN)
            exists = node < self._levels[level][0].shape[1]
            if not exists.all():
                point, node = point[exists], node[exists]
            point, node = self._inside(coordinates, point, node, level)
        return point, self._boxes[node]

    def _inside(
        self, coordinates: FloatArray, point: IntArray, node: IntArray, level: int
    ) -> tuple[IntArray, IntArray]:
        """Those of the pairs in which the node of that level holds the point."""
        for q, low, high in zip(coordinates, *self._levels[level], strict=True):
            here = q.take(point)
            keep = np.flatnonzero((low.take(node) <= here) & (here <= high.take(node)))
            point, node = point.take(keep), node.take(keep)
        return point, node

    def _codes(self, points: FloatArray) -> IntArray:
        """Positions along the curve: the bits of the ranks of the coordinates, interleaved."""
        code = np.zeros(len(points), dtype=np.int64)
        for axis in range(3):
            rank = np.searchsorted(self._sorted[:, axis], points[:, axis])
            code |= _spread((rank * (2**_BITS - 1)) // len(self._sorted)) << axis
        return code


def _spread(n: IntArray) -> IntArray:
    """Two zero bits before each of the 21 bits of a number."""
    for shift, mask in (
        (32, 0x1F00000000FFFF),
        (16, 0x1F0000FF0000FF),
        (8, 0x100F00F00F00F00F),
        (4, 0x10C30C30C30C30C3),
        (2, 0x1249249249249249),
    ):
        n = (n | n << shift) & mask
    return n
