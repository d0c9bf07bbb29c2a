"""T-junctions: vertices that lie on an open edge of another face, which is split there."""

from __future__ import annotations

import numpy as np

from ..mesh.arrays import FloatArray, IntArray
from . import SIX_DIGITS
from .polygons import cut_polygons
from .welding import diagonal, open_edges


def stitched(v: FloatArray, f: IntArray, tolerance: float) -> tuple[IntArray, IntArray]:
    """Split faces at the vertices on open edges that lie on theirs; return parts, and the face that each is a part of.

    A vertex lies on an edge whose distance is at most `tolerance` diagonals, or rounding, and not at its ends.

    >>> v = np.array([[0, 0, 0], [2, 0, 0], [1, 1, 0], [1, 0, 0], [1, -1, 0]], dtype=float)
    >>> parts, face = stitched(v, np.array([[0, 1, 2], [0, 4, 3], [3, 4, 1]]), 0.0)
    >>> parts.tolist(), face.tolist()
    ([[2, 0, 3], [2, 3, 1], [0, 4, 3], [3, 4, 1]], [0, 0, 1, 2])
    """
    rows, half, ends, own = open_edges(v, f)
    near = max(tolerance, SIX_DIGITS) * diagonal(own)
    edge, point, share = _on_edges(own, ends, near)
    inner = (f[half[edge] // 3] != rows[point][:, None]).all(axis=1)
    edge, point, share = edge[inner], point[inner], share[inner]
    if not len(edge):
        return f, np.arange(len(f))
    face, side = np.divmod(half[edge], 3)
    faces, number = np.unique(face, return_inverse=True)
    # A polygon begins opposite a side that is split, so that a fan about its first corner is right.
    begin = np.empty(len(faces), dtype=np.int64)
    begin[number] = side
    of = np.concatenate((np.repeat(np.arange(len(faces)), 3), number))
    at = np.concatenate((np.tile([0.0, 1.0, 2.0], len(faces)), side + 1 + share))
    order = np.lexsort(((at - begin[of]) % 3, of))
    corners = np.concatenate((f[faces].ravel(), rows[point]))[order]
    cut = cut_polygons(v, corners, np.bincount(of))
    whole = np.delete(np.arange(len(f)), faces)
    source = np.concatenate((whole, faces[cut.polygon]))
    order = np.argsort(source, kind="stable")
    return np.concatenate((f[whole], corners[cut.triangles]))[order], source[order]


def _on_edges(
    own: FloatArray, ends: IntArray, near: float
) -> tuple[IntArray, IntArray, FloatArray]:
    """Edges, the vertices on open edges that lie on them, and where: shares of the way along the edge."""
    rim = np.unique(ends)
    rim = rim[np.isfinite(own[rim]).all(axis=1)]
    a, b = own[ends]
    edges = np.flatnonzero(np.isfinite(a + b).all(axis=1))
    if not len(edges):
        return edges, edges, np.empty(0)
    from scipy.spatial import cKDTree  # takes .1 s, which closed meshes don't need

    along = b - a
    length = np.linalg.norm(along, axis=1)
    found = cKDTree(own[rim]).query_ball_point(
        (a + along / 2)[edges], length[edges] / 2 + near, return_sorted=True
    )
    edge = np.repeat(edges, [len(each) for each in found])
    point = rim[np.concatenate(found).astype(np.int64)]
    from_a = own[point] - a[edge]
    share = np.einsum("ij,ij->i", from_a, along[edge]) / np.square(length[edge])
    off = np.linalg.norm(from_a - share[:, None] * along[edge], axis=1)
    from_ends = np.minimum(share, 1 - share) * length[edge]
    on = (off <= near) & (from_ends > near)
    return edge[on], point[on], share[on]
