"""Grouping of a graph's vertices into small connected aggregates: one level of coarsening."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import breadth_first_order


def aggregate(graph: sp.csr_matrix) -> tuple[np.ndarray, int]:
    """Label of each vertex and number of aggregates, which hold about seven vertices each.

    Each vertex whose hash is the largest among its neighbours is a seed, and every vertex joins a nearest seed: a
    Voronoi diagram of the graph, by one breadth-first search from all seeds at once. Seeds are no neighbours, so that
    in a connected graph there are at most n / 2. `graph` has a symmetric pattern and a full diagonal.

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
