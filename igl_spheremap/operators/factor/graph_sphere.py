"""A quick, rough harmonic map of a planar graph to the sphere, from the graph alone.

It needs no accuracy: it only has to be smooth and to keep neighbours together, so that planes cut it into
parts with short common borders.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from ...sphere.rows import row_dots, unit_rows
from .aggregation import aggregate

#: Graphs of up to this size are placed by a dense eigenvalue decomposition.
_COARSEST = 300
#: Averaging sweeps on each level, fewer on the finest, where they cost most: with 3 everywhere factors would have up to
#: half as many entries again (docs/factorisations.md).
_SWEEPS, _FINEST_SWEEPS = 10, 3
#: Weight of the vertex itself in a sweep: it damps oscillating modes.
_SELF_WEIGHT = 0.1
#: Fixed-point steps on the coarsest graph; the map need not be converged.
_PROJECTIONS = 30


def graph_sphere(graph: sp.csr_matrix) -> np.ndarray:
    """Place the vertices of a connected planar graph on the sphere, near the centroids of their neighbours.

    `graph` holds symmetric, non-negative edge weights and a full diagonal, whose values don't matter.

    >>> cycle = sp.csr_matrix(np.eye(6) + np.roll(np.eye(6), 1, axis=1) + np.roll(np.eye(6), -1, axis=1))
    >>> np.linalg.norm(graph_sphere(cycle), axis=1).round(6).tolist()
    [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
    """
    return _multilevel(graph, _FINEST_SWEEPS)


def _multilevel(graph: sp.csr_matrix, sweeps: int) -> np.ndarray:
    """Place the aggregates first, then move each vertex to the centroid of its neighbours, sweep by sweep."""
    n = graph.shape[0]
    if n <= _COARSEST:
        return _coarsest(graph.toarray())
    labels, count = aggregate(graph)
    members = sp.csc_matrix((np.ones(n), labels, np.arange(n + 1)), shape=(count, n)).tocsr()
    joined = sp.csr_matrix((graph.data, labels.take(graph.indices), graph.indptr), shape=(n, count))
    x = _multilevel(members @ joined, _SWEEPS)[labels]
    diagonal = graph.diagonal()
    degree = np.maximum(graph @ np.ones(n) - diagonal, np.finfo(float).tiny)
    own, total = _SELF_WEIGHT * degree - diagonal, (1.0 + _SELF_WEIGHT) * degree
    for _ in range(sweeps):
        x = (graph @ x + own[:, None] * x) / total[:, None]
    return unit_rows(x)


def _coarsest(weights: np.ndarray) -> np.ndarray:
    """Harmonic map of a small graph, by the self-consistent projection x <- unit_rows(L^+ Lambda x)."""
    np.fill_diagonal(weights, 0.0)
    L = np.diag(weights.sum(axis=1)) - weights
    eigenvalues, modes = np.linalg.eigh(L)
    if len(L) < 5 or eigenvalues[1] <= 1e-12 * eigenvalues[-1]:
        # Too small, or not connected: any place will do.
        return unit_rows(np.cos(np.outer(np.arange(len(L)), [1.0, 2.0, 3.0])))
    inverse = (modes[:, 1:] / eigenvalues[1:]) @ modes[:, 1:].T
    x = unit_rows(modes[:, 1:4] / np.sqrt(eigenvalues[1:4]))
    for _ in range(_PROJECTIONS):
        area = np.maximum(row_dots(x, L @ x), 0.0)
        area += 1e-12 * area.max()
        y = inverse @ (area[:, None] * (x - area @ x / area.sum()))
        y -= area @ y / area.sum()
        spread, axes = np.linalg.eigh(y.T @ (area[:, None] * y))
        x = unit_rows(y @ (axes / np.sqrt(np.maximum(spread, np.finfo(float).tiny))) @ axes.T)
    return x
