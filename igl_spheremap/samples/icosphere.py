"""The unit sphere as a subdivided icosahedron."""

from __future__ import annotations

import igl
import numpy as np

from ..errors import check_number
from ..gate import gate
from ..mesh.arrays import FloatArray, IntArray

#: Vertices of a sample at most: a number with too many zeros ends in an error, and not in the swap file.
MOST_VERTICES = 1e9


@gate
def sphere(n_vertices: int = 2562) -> tuple[FloatArray, IntArray]:
    """Unit sphere: an icosahedron with edges cut into k equal parts, ``10 k^2 + 2`` vertices in all.

    If k is even, the first vertices are those of the sphere with k / 2, bit for bit: networks pool by slicing.

    Parameters
    ----------
    n_vertices : int
        Approximate number of vertices: k is the nearest whole number.
    """
    check_number(n_vertices, "n_vertices", 12, MOST_VERTICES)
    k = max(round(float(np.sqrt((n_vertices - 2) / 10.0))), 1)
    corners, sides = igl.icosahedron()
    weight, triangles = _lattice(k)
    points = len(weight)
    corner = np.broadcast_to(sides[:, None, :], (len(sides), points, 3)).reshape(-1, 3)
    weight = np.tile(weight, (len(sides), 1))
    # A point on an edge belongs to two faces, a corner to five: give it the same key in all, corners in rising order.
    corner = np.where(weight > 0, corner, 0)
    order = np.argsort(np.where(weight > 0, corner, 100), axis=1)
    corner, weight = (
        np.take_along_axis(corner, order, axis=1),
        np.take_along_axis(weight, order, axis=1),
    )
    key = (corner @ [1, 12, 144]) * (k + 1) ** 2 + weight[:, :2] @ [1, k + 1]
    common = np.gcd.reduce(weight, axis=1)
    halvings = common & -common  # 2^a: the sphere with k / 2^a has the point, too
    key += (k - halvings) * 12**3 * (k + 1) ** 2
    _, first, index = np.unique(key, return_index=True, return_inverse=True)
    v = np.einsum("ij,ijk->ik", weight[first], corners[corner[first]])
    f = index.reshape(len(sides), points)[:, triangles].reshape(-1, 3)
    return v / np.linalg.norm(v, axis=1, keepdims=True), np.ascontiguousarray(f, dtype=np.int64)


def _lattice(k: int) -> tuple[IntArray, IntArray]:
    """Whole barycentric weights of sum k on one triangle, and the ``k^2`` small triangles among them."""
    i, j = (a.ravel() for a in np.meshgrid(np.arange(k + 1), np.arange(k + 1), indexing="ij"))
    inside = i + j <= k
    row = np.full((k + 2) ** 2, -1)
    row[(i * (k + 2) + j)[inside]] = np.arange(inside.sum())
    i, j = i[inside], j[inside]

    def at(di: int, dj: int) -> IntArray:
        return row[(i + di) * (k + 2) + j + dj]

    up = np.stack([at(0, 0), at(1, 0), at(0, 1)], axis=1)[i + j < k]
    down = np.stack([at(1, 0), at(1, 1), at(0, 1)], axis=1)[i + j < k - 1]
    return np.stack([k - i - j, i, j], axis=1), np.concatenate([up, down])
