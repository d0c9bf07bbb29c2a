"""Polygons as files hold them, and the triangles that come of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import MeshError

IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Polygons:
    """Faces with any number of corners.

    Attributes
    ----------
    corners : (k,) int64 array
        0-based vertex indices of all faces, one face after the other.
    sizes : (m,) int64 array
        Number of corners of each face.
    """

    corners: IntArray
    sizes: IntArray

    def triangles(self, triangulate: bool = False) -> IntArray:
        """The faces as triangles.

        Parameters
        ----------
        triangulate : bool
            Cut polygons into fans about their first corner; by default they are refused.

        Returns
        -------
        (m, 3) int64 array
            Triangles, in the order of the faces.

        Raises
        ------
        MeshError
            If a face has fewer than three corners, or more and `triangulate` is not set.

        Examples
        --------
        >>> Polygons(np.arange(4), np.array([4])).triangles(triangulate=True).tolist()
        [[0, 1, 2], [0, 2, 3]]
        """
        if (self.sizes == 3).all():
            return np.ascontiguousarray(self.corners.reshape(-1, 3), dtype=np.int64)
        self._refuse(np.flatnonzero(self.sizes < 3), "remove them")
        if not triangulate:
            self._refuse(np.flatnonzero(self.sizes > 3), "triangulate them (read_mesh(path, triangulate=True) does)")
        fans = self.sizes - 2
        first = np.repeat(np.cumsum(self.sizes) - self.sizes, fans)
        step = np.arange(len(first)) - np.repeat(np.cumsum(fans) - fans, fans)
        return np.column_stack(
            [self.corners[first], self.corners[first + step + 1], self.corners[first + step + 2]]
        )

    def _refuse(self, bad: IntArray, mend: str) -> None:
        if len(bad):
            which = ", ".join(map(str, bad[:3].tolist()))
            raise MeshError(
                f"faces are not triangles: {len(bad)} of {len(self.sizes)} have other than 3 corners, "
                f"e.g. face {which} with {self.sizes[bad[0]]}; {mend}"
            )


def of_triangles(f: IntArray) -> Polygons:
    """Triangles as polygons.

    Parameters
    ----------
    f : (m, 3) int array
        Faces.

    Returns
    -------
    Polygons
        The same faces.
    """
    f = np.asarray(f, dtype=np.int64).reshape(-1, 3)
    return Polygons(f.ravel(), np.full(len(f), 3))
