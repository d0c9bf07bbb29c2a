"""A seam: the short tree of edges along which a closed surface is cut open."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from ..errors import MeshError
from ..mesh.arrays import FloatArray, IntArray, own_unit

#: Tips that errors suggest to cut through: with 6, 2 of 4 bodies keep their lengths better, 2 worse (tried by hand).
TIPS = 4
_TINY = np.finfo(np.float64).tiny


def seam(v: FloatArray, f: IntArray, points: IntArray | int) -> IntArray:
    """Edges (k, 2) of a tree of shortest paths through vertices, or through as many tips as `points` says.

    Each path joins the tree to the nearest vertex that it lacks; a tip is the vertex farthest from it, as Gu, Gortler
    and Hoppe (2002, Geometry images) extend a cut to the point that is stretched most. The first tip is farthest from
    vertex 0.
    """
    start, stop = f.ravel(), f[:, [1, 2, 0]].ravel()
    own = own_unit(v)[0]
    length = np.maximum(np.linalg.norm(own[start] - own[stop], axis=1), _TINY)  # 0 would be no edge
    graph = csr_matrix((length, (start, stop)), shape=(len(v), len(v)))
    given = None if isinstance(points, int) else np.unique(points)
    tree = np.array([np.argmax(dijkstra(graph, indices=0))]) if given is None else given[:1]
    edges: list[tuple[int, int]] = []
    for _ in range((points if isinstance(points, int) else len(points)) - 1):
        distance, before, _ = dijkstra(graph, indices=tree, return_predecessors=True, min_only=True)
        left = np.arange(len(v)) if given is None else np.setdiff1d(given, tree)
        if not len(left):
            break
        at = int(
            left[np.argmax(distance[left])] if given is None else left[np.argmin(distance[left])]
        )
        while before[at] >= 0:
            edges.append((int(before[at]), at))
            at = int(before[at])
        tree = np.unique(np.append(tree, edges))
    if len(edges) < 2:
        raise MeshError(
            "the points of the cut are neighbours, or one alone; give vertices that are farther apart"
        )
    return np.array(edges)
