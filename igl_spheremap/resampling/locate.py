"""The face of a spherical triangulation that holds a point, exactly, for many points at once."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike

from ..errors import FoldingsRemain, Remedy
from ..gate import gate
from ..maps.sphere_map import SphereMap
from ..mesh.arrays import EPS, FloatArray, IntArray, check_directions, check_rows
from ..mesh.check import MapLike, Mesh, check_faces, rows_and_faces
from ..sphere.rows import row_dets, row_dots, unit_rows
from ..timings import counted
from ..verify.certificate import UNIT_TOLERANCE, Certificate
from ..verify.signs import determinant_signs


@dataclass(frozen=True, eq=False)
class Location:
    """Points on a triangulation. Unpacks to ``face, weights``.

    Attributes
    ----------
    face : (k,) int64 array
        The face that holds each point; of several, on an edge or at a vertex, the first.
    weights : (k, 3) float64 array
        Barycentric weights of its corners, non-negative, of sum 1: the point is the direction of their mean.

    Examples
    --------
    >>> import numpy as np
    >>> import igl_spheremap as ism
    >>> middle = ism.Location(np.array([7]), np.full((1, 3), 1 / 3))  # of face 7
    >>> face, weights = middle
    >>> face.tolist(), weights.round(2).tolist()
    ([7], [[0.33, 0.33, 0.33]])
    """

    face: IntArray
    weights: FloatArray

    def __iter__(self) -> Iterator[Any]:
        return iter((self.face, self.weights))

    def __repr__(self) -> str:
        return f"Location({len(self.face)} points)"


def at_vertices(f: IntArray) -> Location:
    """Return all vertices of a closed mesh as points of faces.

    >>> at_vertices(np.array([[0, 1, 2], [0, 2, 1]])).weights[1]
    array([0., 0., 1.])
    """
    corner = np.empty(int(f.max()) + 1, dtype=np.int64)
    corner[f.ravel()] = np.arange(f.size)
    return Location(corner // 3, np.eye(3)[corner % 3])


def take_points(location: Location, rows: Any) -> Location:
    """Take some of the points."""
    return Location(location.face[rows], location.weights[rows])


def joined(*parts: Location) -> Location:
    """Put points one after the other."""
    return Location(
        np.concatenate([part.face for part in parts]),
        np.concatenate([part.weights for part in parts]),
    )


class SphereLocator:
    """Exact point location on a spherical triangulation.

    A face holds a point if the point's ray from the origin meets it, which is decided in exact arithmetic. Since the
    map is a bijection every point is found, in triangles of any size. Candidates come from a tree of boxes over the
    faces, in the order of a space-filling curve through the *ranks* of their coordinates. It is as deep in limbs 1e-12
    wide as elsewhere.

    Parameters
    ----------
    x : (n, 3) array_like or SphereMap
        Images of the vertices on the unit sphere, or a map, which needs no `f`: folding-free.
    f : (m, 3) array_like or Mesh
        Faces as 0-based vertex indices, or a checked mesh.

    Raises
    ------
    MeshError
        If `f` is not a closed genus-0 mesh on the rows of `x`.
    FoldingsRemain
        If the map is not certified folding-free: location would be ambiguous.

    Examples
    --------
    >>> import numpy as np
    >>> import igl_spheremap as ism
    >>> x, f = ism.samples.sphere(42)
    >>> face, weights = ism.SphereLocator(x, f).locate([[0.1, 0.2, 0.3]])
    >>> y = (weights[:, :, None] * x[f[face]]).sum(axis=1)
    >>> np.allclose(y / np.linalg.norm(y), np.array([1, 2, 3]) / 14**0.5)
    True
    """

    _in_words = "a SphereLocator"

    @gate
    def __init__(self, x: ArrayLike | MapLike, f: ArrayLike | Mesh | None = None) -> None:
        certificate: Certificate | None = None
        if isinstance(x, SphereMap) and f is None:
            certificate = x.certificate
        x, f = rows_and_faces(x, f)
        self.x = check_rows(x)
        self.f = check_faces(f, len(self.x))
        if certificate is None:
            certificate = Certificate.of(self.x, self.f)
        if not certificate.folding_free:
            raise FoldingsRemain(
                f"points can't be located on a map that is {certificate}; repair it "
                f"({Remedy('repair_foldings', given='v, f, x')} does)"
            )
        low, high = _face_boxes(self.x, self.f)
        self._tree = BoxTree(low, high)

    def __repr__(self) -> str:
        return f"SphereLocator({len(self.x)} vertices, {len(self.f)} faces)"

    @gate
    def locate(self, points: ArrayLike) -> Location:
        """Find the faces that hold points.

        Parameters
        ----------
        points : (k, 3) array_like
            Points of the sphere; those of another length than 1 are scaled to it first.

        Returns
        -------
        Location
            Unpacks to faces and barycentric weights.

        Raises
        ------
        MeshError
            If a point is not finite or at the origin.
        """
        q = unit_rows(check_directions(points, name="points"))
        first = np.full(len(q), len(self.f))
        order = self._tree.order_of(q)
        size = 1 << 13  # queries at once, so that their candidates stay in cache
        for start in counted("locating", range(0, len(q), size)):
            block = order[start : start + size]
            query, face = self._tree.candidates(q[block])
            query, corners = block[query], self._corners(face)
            inside = np.ones(len(face), dtype=bool)
            for k in range(3):
                inside &= determinant_signs(q[query], corners[k], corners[k - 2]) >= 0
            np.minimum.at(first, query[inside], face[inside])
        return Location(first, barycentric_weights(q, *self._corners(first)))

    def _corners(self, face: IntArray) -> list[FloatArray]:
        return [self.x[self.f[face, k]] for k in range(3)]


_LOCATORS: WeakKeyDictionary[SphereMap, SphereLocator] = WeakKeyDictionary()


def locator_of(result: SphereMap) -> SphereLocator:
    """Return the locator of a map, which is made once: maps do not change."""
    if result not in _LOCATORS:
        _LOCATORS[result] = SphereLocator(result)
    return _LOCATORS[result]


def barycentric_weights(q: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Compute weights, not negative and of sum 1, with which the corners' mean has the direction of a unit vector q.

    Products are taken of differences from q, so that triangles of any size keep their relative precision.

    >>> q = np.array([[1.0, 1.0, 1.0]]) / 3**0.5
    >>> barycentric_weights(q, *np.eye(3)[:, None, :]).round(6)
    array([[0.333333, 0.333333, 0.333333]])
    """
    # Coordinates, then sides, each in a unit of its own: no product underflows, even close to the end of an axis.
    rows = np.stack((q, a - q, b - q, c - q))
    q, *sides = np.ldexp(rows, -np.frexp(np.abs(rows).max(axis=0))[1])
    longest = np.abs(sides).max(axis=2)
    unit = np.frexp(longest)[1]
    a, b, c = np.ldexp(sides, -unit[:, :, None])
    weights = np.column_stack([row_dets(q, b, c), row_dets(q, c, a), row_dets(q, a, b)])
    weights = np.ldexp(weights, (unit.min(axis=0) - unit).T)
    weights = np.maximum(weights, 0.0)  # rounding only: the exact ones are not negative
    flat = ~weights.any(axis=1)  # seen from q, which is a corner to rounding
    weights[flat] = (longest == longest.min(axis=0)).T[flat]
    return weights / weights.sum(axis=1, keepdims=True)


def _face_boxes(x: FloatArray, f: IntArray) -> tuple[FloatArray, FloatArray]:
    """Compute boxes that hold the spherical triangles.

    A point y of the flat triangle has 1 - |y|^2 = sum of w_i w_j |x_i - x_j|^2 <= d^2 / 3, d its longest
    edge: the spherical triangle lies within 1 - |y| of the flat one.
    """
    a, b, c = (x[f[:, k]] for k in range(3))
    longest = np.max([row_dots(u, u) for u in (b - a, c - b, a - c)], axis=0)
    bulge = 1 - np.sqrt(np.maximum(1 - longest / 3, 0))
    # For rounding of coordinates of size 1, and for rows that are not quite on the unit sphere.
    room = (bulge * (1 + UNIT_TOLERANCE) + 4 * EPS)[:, None]
    return np.minimum(np.minimum(a, b), c) - room, np.maximum(np.maximum(a, b), c) + room


class BoxTree:
    """Boxes in the order of a Morton curve through the ranks of their centres, and boxes around each four.

    Ranks do not depend on scale: the tree is as good for boxes that are twelve orders of magnitude smaller than others.
    """

    #: Children of a node, and bits of a rank: those of three ranks fit into an int64.
    fan, bits = 4, 21

    def __init__(self, low: FloatArray, high: FloatArray) -> None:
        centre = (low + high) / 2
        self._sorted = np.sort(centre, axis=0)
        self._boxes = np.argsort(self._codes(centre), kind="stable")
        low, high = (np.ascontiguousarray(corner[self._boxes].T) for corner in (low, high))
        self._levels = [(low, high)]
        while low.shape[1] > 1:
            start = np.arange(0, low.shape[1], self.fan)
            low = np.minimum.reduceat(low, start, axis=1)
            high = np.maximum.reduceat(high, start, axis=1)
            self._levels.append((low, high))

    def order_of(self, points: FloatArray) -> IntArray:
        """Return a permutation of points in which neighbours are close."""
        return np.argsort(self._codes(points), kind="stable")

    def candidates(self, points: FloatArray) -> tuple[IntArray, IntArray]:
        """Find all pairs of a point and a box that holds it, by their rows."""
        coordinates = np.ascontiguousarray(points.T)
        point, node = np.arange(len(points)), np.zeros(len(points), dtype=np.int64)
        point, node = self._inside(coordinates, point, node, len(self._levels) - 1)
        for level in range(len(self._levels) - 2, -1, -1):
            node = (self.fan * node[:, None] + np.arange(self.fan)).ravel()
            point = np.repeat(point, self.fan)
            exists = node < self._levels[level][0].shape[1]
            if not exists.all():
                point, node = point[exists], node[exists]
            point, node = self._inside(coordinates, point, node, level)
        return point, self._boxes[node]

    def _inside(
        self, coordinates: FloatArray, point: IntArray, node: IntArray, level: int
    ) -> tuple[IntArray, IntArray]:
        """Keep the pairs in which the node of that level holds the point."""
        for q, low, high in zip(coordinates, *self._levels[level], strict=True):
            here = q.take(point)
            keep = np.flatnonzero((low.take(node) <= here) & (here <= high.take(node)))
            point, node = point.take(keep), node.take(keep)
        return point, node

    def _codes(self, points: FloatArray) -> IntArray:
        """Compute positions along the curve: the bits of the ranks of the coordinates, interleaved."""
        code = np.zeros(len(points), dtype=np.int64)
        for axis in range(3):
            rank = np.searchsorted(self._sorted[:, axis], points[:, axis])
            code |= _with_gaps((rank * (2**self.bits - 1)) // len(self._sorted)) << axis
        return code


def _with_gaps(n: IntArray) -> IntArray:
    """Put two zero bits before each of the 21 bits of a number."""
    for shift, mask in (
        (32, 0x1F00000000FFFF),
        (16, 0x1F0000FF0000FF),
        (8, 0x100F00F00F00F00F),
        (4, 0x10C30C30C30C30C3),
        (2, 0x1249249249249249),
    ):
        n = (n | n << shift) & mask
    return n
