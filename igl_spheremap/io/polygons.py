"""Polygons as files hold them, and the triangles that come of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError
from ..mesh.arrays import IntArray
from ..mesh.check import check_triangles


@dataclass(frozen=True, eq=False)
class Polygons:
    """Faces with any number of corners: all corners in one row, (k,) int64, and the number of each face's, (m,)."""

    corners: IntArray
    sizes: IntArray

    def triangles(self, triangulate: bool = False) -> IntArray:
        """The faces as (m, 3) triangles; polygons are refused, or cut into fans about their first corner.

        Examples
        --------
        >>> Polygons(np.arange(4), np.array([4])).triangles(triangulate=True).tolist()
        [[0, 1, 2], [0, 2, 3]]
        """
        if (self.sizes == 3).all():
            return np.ascontiguousarray(self.corners.reshape(-1, 3))
        self._refuse(np.flatnonzero(self.sizes < 3), "remove them")
        if not triangulate:
            self._refuse(np.flatnonzero(self.sizes > 3), "triangulate them (read_mesh(path, triangulate=True) does)")
        fans = self.sizes - 2
        first = np.repeat(np.cumsum(self.sizes) - self.sizes, fans)
        step = np.arange(len(first)) - np.repeat(np.cumsum(fans) - fans, fans)
        return np.column_stack([self.corners[first], self.corners[first + step + 1], self.corners[first + step + 2]])

    def _refuse(self, bad: IntArray, remedy: str) -> None:
        if len(bad):
            which = ", ".join(map(str, bad[:3].tolist()))
            raise MeshError(f"faces are not triangles: {len(bad)} of {len(self.sizes)} have other than 3 corners, "
                            f"e.g. face {which} with {self.sizes[bad[0]]}; {remedy}")


def of_triangles(f: ArrayLike) -> Polygons:
    """Triangles as polygons, checked to be (m, 3) whole numbers."""
    f = check_triangles(f)
    return Polygons(f.ravel(), np.full(len(f), 3))
