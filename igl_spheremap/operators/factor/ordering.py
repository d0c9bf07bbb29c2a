"""Fill-reducing orders for sparse symmetric matrices with the pattern of a mesh of genus 0."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import breadth_first_order, reverse_cuthill_mckee

from .graph_sphere import graph_sphere

Numbering = Callable[[sp.csr_matrix], np.ndarray]


@dataclass(frozen=True)
class Dissection:
    """A nested dissection: an elimination order and the binary tree of parts behind it.

    Parts are numbered by paths: at height h (0 for the leaves, `depth` for the whole graph) a vertex
    belongs to the part ``path >> h``. Vertices that separate the two halves of a part have that part's
    height; vertices of a leaf have 0.
    """

    # vertex that is eliminated i-th; each part's vertices follow one another, its separator last
    order: np.ndarray
    path: np.ndarray  # leaf on whose side the i-th eliminated vertex lies
    height: np.ndarray  # height of the part that the i-th eliminated vertex separates
    depth: int  # height of the tree


def bandwidth_order(P: sp.csr_matrix) -> np.ndarray:
    """Number vertices so that neighbours are close in memory (reverse Cuthill-McKee); return the i-th vertex.

    A good start for minimum degree orders, which break ties by index.
    """
    return reverse_cuthill_mckee(P, symmetric_mode=True)


def breadth_first(P: sp.csr_matrix) -> np.ndarray:
    """Number the vertices of a connected graph by a breadth-first search, the last ones found first.

    As good as `bandwidth_order` before minimum degree, in a fifth of the time.
    """
    return np.ascontiguousarray(breadth_first_order(P, 0, return_predecessors=False)[::-1])


def inverse_permutation(order: np.ndarray) -> np.ndarray:
    """The place of each index in an order."""
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order), dtype=order.dtype)
    return rank


def renumbered(P: sp.csr_matrix, order: np.ndarray) -> sp.csr_matrix:
    """P[order][:, order], with the columns of each row unsorted."""
    A = P[order]
    A.indices = inverse_permutation(order).take(A.indices)
    A.has_sorted_indices = False
    return A


def nested_dissection(
    P: sp.csr_matrix, numbering: Numbering = bandwidth_order, leaf: int = 12, sample: int = 2
) -> Dissection:
    """Dissect the graph of a matrix by planes through its rough map to the sphere.

    Planes cut a mesh of genus 0 well on a conformal sphere: each half of a part has half of its vertices, and a
    separator of about the square root of their number (George 1973, *Nested Dissection of a Regular Finite Element
    Mesh*; Miller, Teng, Thurston, Vavasis 1997, *Separators for Sphere-Packings and Nearest Neighbor Graphs*). Only
    the graph is used, so that the order depends neither on how the surface is folded nor, apart from ties, on how its
    vertices are numbered. Parts of about `leaf` vertices are dissected no further; leaves of
    12 to 96 cost the same (benchmarks/tried.md). Planes are medians over `sample` vertices a leaf. `P` has a symmetric
    pattern and a full diagonal; graphs that are not planar are ordered correctly, but not well.

    >>> line = sp.diags_array([np.ones(19)] * 2, offsets=[-1, 1])
    >>> grid = sp.kronsum(line, line) + sp.eye_array(400)
    >>> dissection = nested_dissection(grid.tocsr(), leaf=25)
    >>> sorted(dissection.order.tolist()) == list(range(400)), dissection.depth
    (True, 4)
    """
    n = P.shape[0]
    # everything below gathers along edges: worth a cache-friendly numbering
    local = numbering(P)
    graph = renumbered(P, local)
    graph.data = np.ones(graph.nnz)
    depth = max(1, int(np.ceil(np.log2(max(n, 2) / leaf))))
    # The best separator would hold a vertex with that many neighbours: these would fill more than it does. (Amestoy,
    # Davis and Duff 2004, Algorithm 837: AMD, put such rows last, too.)
    hub = np.diff(graph.indptr) > 10 * np.sqrt(n)
    x = _on_sphere(graph, hub)
    sampled = (np.arange(sample << depth) * n) // (sample << depth)
    path = _follow(x, _cutting_planes(x.take(sampled, axis=1), depth))
    height = _separator_heights(graph, path, depth, hub)
    order = _children_first(path, height)
    return Dissection(local[order], path[order], height[order], depth)


def _on_sphere(graph: sp.csr_matrix, hub: np.ndarray) -> np.ndarray:
    """Places (3, n) of the vertices on the sphere. Hubs are at 0: they would draw all others to one place."""
    if not hub.any():
        return np.ascontiguousarray(graph_sphere(graph).T)
    body, x = np.flatnonzero(~hub), np.zeros((3, len(hub)))
    x[:, body] = graph_sphere(graph[body][:, body]).T
    return x


def _cutting_planes(x: np.ndarray, depth: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Halve the points in the columns `depth` times; for each level, the axis and threshold of every part."""
    parts = x[:, None]
    planes = []
    for _ in range(depth):
        axis = parts.var(axis=2).argmax(axis=0)
        along = parts[axis, np.arange(len(axis))]
        middle = along.shape[1] // 2
        order = np.argpartition(along, middle, axis=1)
        planes.append((axis, np.take_along_axis(along, order[:, middle, None], axis=1)[:, 0]))
        parts = np.take_along_axis(parts, order[None], axis=2).reshape(3, -1, middle)
    return planes


def _follow(x: np.ndarray, planes: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Path of each point down the tree of planes, a bit for each."""
    n = x.shape[1]
    coordinates, index = x.ravel(), np.arange(n)
    path = np.zeros(n, np.int64)
    for axis, threshold in planes:
        above = coordinates.take(index + (n * axis).take(path)) >= threshold.take(path)
        path = 2 * path
        path[above] += 1
    return path


def _children_first(path: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Vertices by the last leaf of the part that they separate, then by height: each part before its separator."""
    n, last_leaf = len(path), path | ((np.int64(1) << height) - 1)
    key = last_leaf * 64 + height  # heights are below 64
    return np.sort(key * n + np.arange(n)) % n


def _separator_heights(
    graph: sp.csr_matrix, path: np.ndarray, depth: int, hub: np.ndarray
) -> np.ndarray:
    """Height of the part that each vertex separates: 0 for none, `depth` for hubs.

    An edge is cut at the highest bit in which its ends' paths differ. Unless one of its ends is in a higher
    separator, the end with more edges cut there goes to the separator; if both have as many, the end in the upper half.
    """
    rows = np.repeat(np.arange(graph.shape[0], dtype=np.int32), np.diff(graph.indptr))
    upper = np.flatnonzero(path[rows] > path[graph.indices])
    rows, columns = rows[upper], graph.indices[upper]
    cut = np.frexp((path[rows] ^ path[columns]).astype(np.float64))[1].astype(np.int8)
    order = np.argsort(-cut, kind="stable")
    rows, columns = rows[order], columns[order]
    first = np.append(0, np.cumsum(np.bincount(cut, minlength=depth + 1)[::-1]))
    height = np.where(hub, depth, 0)
    for i, level in enumerate(range(depth, 0, -1)):
        these = slice(first[i], first[i + 1])
        r, c = rows[these], columns[these]
        left = (height[r] == 0) & (height[c] == 0)
        r, c = r[left], c[left]
        edges = np.bincount(np.concatenate((r, c)), minlength=len(height))
        height[c[edges[c] > edges[r]]] = level
        height[r[height[c] == 0]] = level
    return height
