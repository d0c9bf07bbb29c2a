"""A seam: the short tree of edges along which a closed surface is cut open."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from ..errors import MeshError
from ..mesh.arrays import TINY, FloatArray, IntArray, own_unit
from ..mesh.edges import edge_keys, sides


def seam(
    v: FloatArray, f: IntArray, points: IntArray | int, rims: Sequence[IntArray] = ()
) -> IntArray:
    """Edges (k, 2) of a tree of shortest paths that joins boundary loops and vertices, or as many loops and tips.

    Each path joins the tree to the nearest missing item; a tip is the vertex farthest from it, as Gu, Gortler and Hoppe
    (2002, Geometry images) extend a cut to the point that is stretched most. Without loops the first tip is farthest
    from vertex 0.
    """
    n = len(v)
    keys = np.unique(edge_keys(*sides(f), n))
    start, stop = keys // n, keys % n
    own = own_unit(v)[0]
    length = np.maximum(np.linalg.norm(own[start] - own[stop], axis=1), TINY)  # 0 would be no edge
    graph = csr_matrix((length, (start, stop)), shape=(n, n))
    graph = graph + graph.T
    ends, tips = list(rims), 0
    if isinstance(points, int):
        if not ends:
            ends.append(np.argmax(dijkstra(graph, indices=0), keepdims=True))
        tips = points - len(ends)
    else:
        ends += list(np.unique(points)[:, None])
    tree, ends = ends[0], ends[1:]
    edges: list[tuple[int, int]] = []
    while ends or tips > 0:
        distance, before, _ = dijkstra(graph, indices=tree, return_predecessors=True, min_only=True)
        if ends:
            k = int(np.argmin([distance[end].min() for end in ends]))
            end = ends.pop(k)
            at = int(end[np.argmin(distance[end])])
        else:
            at, tips = int(np.argmax(distance)), tips - 1
            end = np.array([at])
        while before[at] >= 0:
            edges.append((int(before[at]), at))
            at = int(before[at])
        tree = np.unique(np.concatenate((tree, end, np.array(edges, dtype=np.int64).ravel())))
    if not edges or (len(edges) < 2 and not rims):
        raise MeshError(
            "the points of the cut are neighbours, or one alone; give vertices that are farther apart"
        )
    return np.array(edges)
