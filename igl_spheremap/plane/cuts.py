"""The cuts of a template's flat map, carried to a surface that is registered to it."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from ..errors import MeshError
from ..mesh.arrays import TINY, FloatArray, IntArray
from ..mesh.edges import components, marked, sides
from ..sphere.rows import row_lengths


def carry_cuts(
    f: IntArray, x: FloatArray, template_f: IntArray, template_x: FloatArray, kept: IntArray
) -> IntArray:
    """Edges (k, 2) of a surface with unit sphere x that stand for the cuts of a patch of a template.

    The patch has the vertices `kept` of the template. Its gap, a medial wall with cuts, is connected, and so is the
    gap's boundary. Each vertex of that goes to the nearest one of the surface, each edge to a shortest path. So the
    paths are connected, and divide the surface into disks.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> from igl_spheremap.plane.cuts import carry_cuts
    >>> x, f = ism.samples.sphere(642)
    >>> coarse, g = ism.samples.sphere(162)
    >>> above = (coarse[:, 2] > -0.5).nonzero()[0]
    >>> disk = ism.repair_disk(x, f, cut=carry_cuts(f, x, g, coarse, above), keep_largest=True)
    >>> bool(disk.v[:, 2].min() > -0.8), len(ism.check_disk(disk).rim) > 10
    (True, True)
    """
    edges = _boundary(template_f, len(template_x), kept)
    rows, index = np.unique(edges, return_inverse=True)
    ends = cKDTree(x).query(template_x[rows])[1][index.reshape(-1, 2)]
    ends = np.unique(np.sort(ends[ends[:, 0] != ends[:, 1]]), axis=0)
    start, stop = sides(f)
    length = np.maximum(row_lengths(x[start] - x[stop]), TINY)
    graph = csr_matrix((length, (start, stop)), shape=(len(x), len(x)))
    # a path of more than three times the distance of its ends is rare: a second search looks for it
    paths = [_path(graph, a, b, 3.0 * float(np.linalg.norm(x[a] - x[b]))) for a, b in ends]
    return np.unique(np.sort(np.concatenate(paths)), axis=0)


def _boundary(f: IntArray, n: int, kept: IntArray) -> IntArray:
    """The edges between vertices that a patch lacks, beside a face with one that it has."""
    lacks = ~marked(kept, n)
    (start, stop), apex = sides(f), f.ravel()
    inside = lacks[start] & lacks[stop]
    _, label = components(start[inside], stop[inside], n)
    # If a patch passes there twice, only the vertices between join a cut to the wall.
    beside = ~lacks[start] & lacks[stop]
    least, most = np.full(n, n), np.full(n, -1)
    np.minimum.at(least, start[beside], label[stop[beside]])
    np.maximum.at(most, start[beside], label[stop[beside]])
    lacks |= least < most
    inside = lacks[start] & lacks[stop]
    _, label = components(start[inside], stop[inside], n)
    # Single holes of the patch are no cuts.
    lacks &= label == np.bincount(label[lacks], minlength=1).argmax()
    edge = lacks[start] & lacks[stop] & ~lacks[apex]
    if not edge.any():
        raise MeshError(
            "the patch lacks no two neighbours of its template: nothing is cut; give a patch without the medial wall, "
            "and the template that it was cut from"
        )
    return np.column_stack((start[edge], stop[edge]))


def _path(graph: csr_matrix, start: int, stop: int, limit: float) -> IntArray:
    """The edges (k, 2) of the shortest path between two vertices."""
    for most in (limit, np.inf):
        before = dijkstra(graph, indices=start, limit=most, return_predecessors=True)[1]
        if before[stop] >= 0:
            break
    path = [stop]
    while path[-1] != start:
        path.append(before[path[-1]])
    return np.column_stack((path[:-1], path[1:]))
