"""Contents of files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError, Remedy
from ..mesh.arrays import AnyArray, BoolArray, FloatArray, IntArray, check_triangles
from ..mesh_repair.polygons import cut_polygons

Metadata = Mapping[str, Any]
#: Arrays by their names, and numbers over vertices by theirs.
NamedArrays = dict[str, AnyArray]
ScalarMaps = dict[str, FloatArray]


@dataclass(frozen=True, eq=False)
class Polygons:
    """Faces with any number of corners: all corners in one row, (k,) int64, and the number of each face's, (m,)."""

    corners: IntArray
    sizes: IntArray

    def triangles(self) -> IntArray:
        """The faces as (m, 3) triangles; polygons are refused.

        Examples
        --------
        >>> Polygons(np.arange(6), np.array([3, 3])).triangles().tolist()
        [[0, 1, 2], [3, 4, 5]]
        """
        self._refuse(np.flatnonzero(self.sizes < 3), "remove them")
        self._refuse(
            np.flatnonzero(self.sizes > 3),
            "triangulate them",
            Remedy("read_mesh", {"triangulate": True}, "path"),
        )
        return np.ascontiguousarray(self.corners.reshape(-1, 3))

    def cut(self, v: FloatArray) -> tuple[IntArray, int, int]:
        """The faces as triangles, polygons cut, and the numbers of polygons, and of concave ones."""
        self._refuse(np.flatnonzero(self.sizes < 3), "remove them")
        polygons = int(np.count_nonzero(self.sizes > 3))
        if not polygons:
            return self.triangles(), 0, 0
        cut = cut_polygons(v, self.corners, self.sizes)
        return self.corners[cut.triangles], polygons, int(np.count_nonzero(cut.concave))

    def _refuse(self, bad: IntArray, hint: str, remedy: Remedy | None = None) -> None:
        if len(bad):
            which = ", ".join(map(str, bad[:3].tolist()))
            raise MeshError(
                f"faces are not triangles: {len(bad)} of {len(self.sizes)} have other than 3 corners, "
                f"e.g. face {which} with {self.sizes[bad[0]]}; {hint}",
                remedy,
            )


def of_triangles(f: ArrayLike) -> Polygons:
    """Triangles as polygons, checked to be (m, 3) whole numbers."""
    f = check_triangles(f)
    return Polygons(f.ravel(), np.full(len(f), 3))


def ending(corners: IntArray, ends: IntArray) -> Polygons:
    """Polygons by the ends of their corners, one behind another.

    >>> ending(np.arange(7), np.array([3, 7])).sizes.tolist()
    [3, 4]
    """
    sizes = np.diff(ends, prepend=0)
    if (sizes < 0).any() or sizes.sum() != len(corners):
        raise MeshError(
            "damaged: the ends of polygons do not rise to the number of their corners; write the file anew"
        )
    return Polygons(corners, sizes)


@dataclass(frozen=True, eq=False)
class RawMesh:
    """A reader's findings: positions of any dtype, polygons, and metadata that the writer can keep.

    ``sphere`` are the positions on the sphere of a file that holds a map.
    """

    v: AnyArray
    faces: Polygons
    metadata: Metadata = field(default_factory=dict)
    sphere: AnyArray | None = None


@dataclass(frozen=True)
class Label:
    """A row of a table of labels.

    Attributes
    ----------
    key : int
        The number that vertices with this label have.
    name : str
        Its name.
    rgba : (4,) tuple of float
        Red, green, blue and alpha from 0 to 1.
    """

    key: int
    name: str
    rgba: tuple[float, float, float, float]


#: All labels, in the order of a file.
LabelTable = tuple[Label, ...]


@dataclass(frozen=True, eq=False)
class LoadedMesh:
    """A triangle mesh from a file. Unpacks to ``v, f``.

    Attributes
    ----------
    v : (n, 3) float64 array
        Vertex positions, not checked to be finite.
    f : (m, 3) int64 array
        0-based faces, not checked to form a closed surface.
    metadata : dict
        Data that the format's writers can keep: ``structure`` and ``coordinate_system`` (GIFTI), ``volume``
        (FreeSurfer), ``point_data``, arrays by name with a row a vertex (VTK); and ``caps``, faces that only close
        holes and cuts (NPZ files of maps).
    triangulated : int
        Number of polygons of the file that were cut into triangles.
    concave : int
        Number of these in which a corner turns inwards.
    """

    v: FloatArray
    f: IntArray
    metadata: Metadata = field(default_factory=dict)
    triangulated: int = 0
    concave: int = 0

    @property
    def caps(self) -> BoolArray | None:
        """The faces that only close holes and cuts, (m,); None if there are none."""
        return self.metadata.get("caps")

    def __repr__(self) -> str:
        return f"LoadedMesh({len(self.v)} vertices, {len(self.f)} faces)"

    def __iter__(self) -> Iterator[Any]:
        return iter((self.v, self.f))
