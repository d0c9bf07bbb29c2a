"""The cuts of a template's flat map, carried to a surface that is registered to it."""

from __future__ import annotations

import igl
import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from ..errors import MeshError
from ..mesh.arrays import TINY, FloatArray, IntArray
from ..mesh.edges import components, sides
from ..sphere.rows import row_lengths


def carry_cuts(f: IntArray, x: FloatArray, patch_f: IntArray, patch_x: FloatArray) -> IntArray:
    """Edges (k, 2) of a surface with unit sphere x that stand for the boundary of a template's patch.

    Each vertex of the boundary goes to the nearest one of the surface, each edge to a shortest path. So the paths are
    connected, and divide the surface into disks, of which the largest stands for the patch.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> from igl_spheremap.plane.cuts import carry_cuts
    >>> x, f = ism.samples.sphere(642)
    >>> coarse, g = ism.samples.sphere(162)
    >>> above = g[(coarse[g, 2] > -0.5).all(axis=1)]
    >>> disk = ism.repair_disk(x, f, cut=carry_cuts(f, x, above, coarse), keep_largest=True)
    >>> bool(disk.v[:, 2].min() > -0.8), len(ism.check_disk(disk).rim) > 10
    (True, True)
    """
    edges = _boundary(patch_f)
    rows, index = np.unique(edges, return_inverse=True)
    ends = cKDTree(x).query(patch_x[rows])[1][index.reshape(-1, 2)]
    ends = np.unique(np.sort(ends[ends[:, 0] != ends[:, 1]]), axis=0)
    start, stop = sides(f)
    length = np.maximum(row_lengths(x[start] - x[stop]), TINY)
    graph = csr_matrix((length, (start, stop)), shape=(len(x), len(x)))
    # a path of more than three times the distance of its ends is rare: a second search looks for it
    paths = [_path(graph, a, b, 3.0 * float(np.linalg.norm(x[a] - x[b]))) for a, b in ends]
    return np.unique(np.sort(np.concatenate(paths)), axis=0)


def _boundary(f: IntArray) -> IntArray:
    """The edges (k, 2) of the boundary of a patch, without those around single holes, which are no cuts."""
    edges = np.asarray(igl.boundary_facets(f)[0], dtype=np.int64)
    if not len(edges):
        raise MeshError(
            "the patch has no boundary in its template: nothing is cut; give a patch without the medial wall, "
            "and the template that it was cut from"
        )
    label = components(edges[:, 0], edges[:, 1], f.max() + 1)[1][edges[:, 0]]
    return edges[label == np.bincount(label).argmax()]


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
