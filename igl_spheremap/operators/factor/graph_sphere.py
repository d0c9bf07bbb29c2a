"""A quick, rough harmonic map of a planar graph to the sphere, from the graph alone, by aggregates of its vertices.

It need not be accurate, only smooth and with neighbours close together, so that planes cut the graph into parts by
small separators.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import breadth_first_order

from ...mesh.arrays import ROUNDING, TINY
from ...sphere.rows import row_dots, unit_rows


def graph_sphere(
    graph: sp.csr_matrix, sweeps: int = 3, coarser_sweeps: int = 10, coarsest: int = 300
) -> np.ndarray:
    """Place the vertices of a planar graph on the sphere, near the centroids of their neighbours.

    Aggregates are placed first, by more sweeps, as these cost less there. Then each vertex moves to the centroid of its
    neighbours, sweep by sweep. Graphs of up to `coarsest` vertices are placed by a dense eigenvalue decomposition.
    `graph` holds symmetric, non-negative edge weights and a full diagonal, whose values don't matter.

    >>> cycle = sp.csr_matrix(np.eye(6) + np.roll(np.eye(6), 1, axis=1) + np.roll(np.eye(6), -1, axis=1))
    >>> np.linalg.norm(graph_sphere(cycle), axis=1).round(6).tolist()
    [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
    """
    n = graph.shape[0]
    if n <= coarsest:
        return _coarsest(graph.toarray())
    labels, count = aggregate(graph)
    if count == n:  # no edges
        return _anywhere(n)
    members = sp.csc_matrix((np.ones(n), labels, np.arange(n + 1)), shape=(count, n)).tocsr()
    joined = sp.csr_matrix((graph.data, labels.take(graph.indices), graph.indptr), shape=(n, count))
    x = graph_sphere(members @ joined, coarser_sweeps)[labels]
    diagonal = graph.diagonal()
    degree = np.maximum(graph @ np.ones(n) - diagonal, TINY)
    self_weight = 0.1  # it damps modes that oscillate from vertex to vertex
    own, total = self_weight * degree - diagonal, (1.0 + self_weight) * degree
    for _ in range(sweeps):
        x = (graph @ x + own[:, None] * x) / total[:, None]
    return unit_rows(x)


def _coarsest(weights: np.ndarray, steps: int = 30) -> np.ndarray:
    """Harmonic map of a small graph, by steps x <- unit_rows(L^+ Lambda x), which need not have converged."""
    np.fill_diagonal(weights, 0.0)
    L = np.diag(weights.sum(axis=1)) - weights
    eigenvalues, modes = np.linalg.eigh(L)
    if len(L) < 5 or eigenvalues[1] <= ROUNDING * eigenvalues[-1]:
        return _anywhere(len(L))  # too small, or not connected
    inverse = (modes[:, 1:] / eigenvalues[1:]) @ modes[:, 1:].T
    x = unit_rows(modes[:, 1:4] / np.sqrt(eigenvalues[1:4]))
    for _ in range(steps):
        area = np.maximum(row_dots(x, L @ x), 0.0)
        area += ROUNDING * area.max()
        y = inverse @ (area[:, None] * (x - area @ x / area.sum()))
        y -= area @ y / area.sum()
        spread, axes = np.linalg.eigh(y.T @ (area[:, None] * y))
        x = unit_rows(y @ (axes / np.sqrt(np.maximum(spread, TINY))) @ axes.T)
    return x


def _anywhere(n: int) -> np.ndarray:
    """Any positions, for graphs that no map suits."""
    return unit_rows(np.cos(np.outer(np.arange(n), [1.0, 2.0, 3.0])))


def aggregate(graph: sp.csr_matrix) -> tuple[np.ndarray, int]:
    """Label of each vertex and number of aggregates, which hold about seven vertices each.

    Each vertex whose hash is the largest among its neighbours is a seed. Every vertex joins a nearest seed: a Voronoi
    diagram of the graph, by one breadth-first search from all seeds at once. Seeds are not neighbours, so that in a
    connected graph there are at most n / 2. `graph` has a symmetric pattern and a full diagonal.

    >>> path = sp.diags_array([np.ones(8), np.ones(9), np.ones(8)], offsets=[-1, 0, 1]).tocsr()
    >>> labels, count = aggregate(path)
    >>> sorted(set(labels.tolist())) == list(range(count)), bool((np.diff(labels) != 0).sum() == count - 1)
    (True, True)
    """
    n = graph.shape[0]
    rank = _scramble(n)
    largest = np.maximum.reduceat(rank[graph.indices], graph.indptr[:-1])
    seeds = np.flatnonzero(rank == largest).astype(np.int32)
    labels = np.empty(n, np.int32)
    labels[seeds] = np.arange(len(seeds), dtype=np.int32)
    return labels[_nearest_seed(graph, seeds)], len(seeds)


def _nearest_seed(graph: sp.csr_matrix, seeds: np.ndarray) -> np.ndarray:
    """A nearest seed of each vertex, by breadth-first search from an extra vertex that is joined to all seeds."""
    n = graph.shape[0]
    indptr = np.append(graph.indptr, graph.indptr[-1] + len(seeds))
    indices = np.concatenate([graph.indices, seeds])
    joined = sp.csr_matrix((np.ones(len(indices), np.int8), indices, indptr), shape=(n + 1, n + 1))
    owner = breadth_first_order(joined, n, directed=True)[1][:n]
    owner[seeds] = seeds
    while True:  # pointer jumping: doubles the distance followed
        further = owner[owner]
        if np.array_equal(further, owner):
            return owner
        owner = further


def _scramble(n: int) -> np.ndarray:
    """Distinct pseudo-random int64 keys for 0..n-1: a bijective integer hash (splitmix64)."""
    x = np.arange(1, n + 1, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return (x ^ (x >> np.uint64(31))).view(np.int64)
