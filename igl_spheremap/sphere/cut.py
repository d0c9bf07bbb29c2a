"""A mesh cut along coordinate planes of the sphere: geometry as before, and no face across a plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix, identity, vstack

from ..mesh.arrays import FloatArray, IntArray
from ..mesh.edges import edge_keys


@dataclass(frozen=True, eq=False)
class CutMesh:
    """A mesh with the points where its edges cross some planes as further vertices."""

    x: FloatArray  # the old vertices, then new ones on old edges, exactly 0 in the coordinate that cut
    f: IntArray  # each face on one side of every plane
    weights: csr_matrix  # takes values at the old vertices to values at all vertices, along the edges


def cut_along_planes(x: FloatArray, f: IntArray, axes: tuple[int, ...]) -> CutMesh:
    """Cut a mesh along the planes through the origin where one of the `axes` (0 to 2) vanishes, one after the other.

    Where two planes have cut, their common axis is a vertex. Interpolated positions lie on the flat faces.

    >>> x = np.array([[1.0, 0, 1], [-1, 1, 1], [-1, -1, 1]])
    >>> cut = cut_along_planes(x, np.array([[0, 1, 2]]), (0, 1))
    >>> len(cut.x), len(cut.f), cut.x[-1].tolist()
    (8, 8, [0.0, 0.0, 1.0])
    """
    cut = CutMesh(x, f, identity(len(x), format="csr"))
    for axis in axes:
        cut = _cut(cut, axis)
    return cut


def _cut(mesh: CutMesh, axis: int) -> CutMesh:
    s, f = mesh.x[:, axis], mesh.f
    n = len(s)
    side = np.sign(s).astype(np.int64)
    crossing = side[f] * side[f[:, [1, 2, 0]]] < 0  # of edge k, from corner k to the next
    count = crossing.sum(axis=1)
    # Turn faces so that of two crossed edges they are the first and the last, and that a single one is the
    # second.
    first = np.where(count == 2, (np.argmin(crossing, axis=1) + 2) % 3, (np.argmax(crossing, axis=1) + 2) % 3)
    corner = np.take_along_axis(f, (first[:, None] + np.arange(3)) % 3, axis=1)
    a, b, c = corner.T
    one, two = count == 1, count == 2
    starts = np.concatenate([a[two], c[two], b[one]])
    stops = np.concatenate([b[two], a[two], c[one]])
    edges, index = np.unique(edge_keys(starts, stops, n), return_inverse=True)
    p, q, r = np.split(n + index, [two.sum(), 2 * two.sum()])
    pieces = [f[count == 0]]
    pieces += [np.stack(t, axis=1) for t in ((a[two], p, q), (p, b[two], c[two]), (p, c[two], q))]
    pieces += [np.stack(t, axis=1) for t in ((a[one], b[one], r), (a[one], r, c[one]))]
    i, j = edges // n, edges % n
    t = s[i] / (s[i] - s[j])
    k = np.arange(len(edges))
    along = csr_matrix(
        (np.concatenate([1 - t, t]), (np.concatenate([k, k]), np.concatenate([i, j]))), (len(k), n)
    )
    points = along @ mesh.x
    points[:, axis] = 0
    return CutMesh(
        np.concatenate([mesh.x, points]),
        np.concatenate(pieces),
        vstack([mesh.weights, along @ mesh.weights], format="csr"),
    )
