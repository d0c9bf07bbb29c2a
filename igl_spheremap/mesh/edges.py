"""The half-edges of triangles, which are the pattern of a closed mesh's sparse matrices; faces at vertices; components.

Half-edge 3 i + k is the side of face i opposite corner k, as in libigl: its apex is the vertex ``f.ravel()[3 i + k]``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import connected_components

from .arrays import BoolArray, IntArray

Indices = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Patch:
    """A part of a closed mesh with vertices of its own numbers.

    Attributes
    ----------
    vertices : (k,) int array
        Numbers of its vertices in the mesh, ascending.
    f : (j, 3) int64 array
        Its faces.
    rim : (k,) bool array
        Vertices with further faces in the mesh.
    """

    vertices: IntArray
    f: IntArray
    rim: BoolArray


@dataclass(frozen=True, eq=False)
class HalfEdges:
    """The half-edges of a closed mesh, as the pattern of matrices with an entry for each edge and each vertex.

    The pattern is in compressed rows with sorted columns. On the diagonal `half` and `twin` are 3 m or more.
    `shared_edges` serves triangles that are not closed, or meet otherwise than in pairs.

    Attributes
    ----------
    faces : (m, 3) int32 array
        A copy of the faces.
    indptr, indices : int32 arrays
        The pattern, as of `scipy.sparse.csr_matrix`.
    half : (7 n - 12,) int32 array
        Of each entry, the half-edge that runs from its row to its column.
    twin : (7 n - 12,) int32 array
        Of each entry, the half-edge that runs back.
    diagonal : (n,) int32 array
        The entry on the diagonal of each row.
    """

    faces: Indices
    indptr: Indices
    indices: Indices
    half: Indices
    twin: Indices
    diagonal: Indices

    def __repr__(self) -> str:
        return f"HalfEdges({len(self.diagonal)} vertices, {len(self.faces)} faces)"

    def twins(self) -> Indices:
        """The half-edge that runs back, for each half-edge, (3 m,)."""
        twin = np.empty(len(self.half), dtype=np.int32)
        twin[self.half] = self.twin
        return twin[: self.faces.size]

    def within(self, vertices: IntArray, rings: int) -> IntArray:
        """All vertices within `rings` edges of given ones, in ascending order."""
        mask = marked(vertices, len(self.diagonal))
        found = np.flatnonzero(mask)
        for _ in range(rings):
            mask[self.indices.take(self._of_rows(found))] = True
            found = np.flatnonzero(mask)
        return found

    def faces_at(self, vertices: IntArray) -> IntArray:
        """Faces that have one of several distinct vertices, in ascending order."""
        return np.flatnonzero(marked(half_edges_out(self, vertices)[1] // 3, len(self.faces)))

    def patch_around(self, vertices: IntArray, rings: int) -> Patch:
        """The faces around all vertices within `rings` edges of given ones."""
        faces = self.faces[self.faces_at(self.within(vertices, rings))]
        n = len(self.diagonal)
        names, number = np.flatnonzero(marked(faces, n)), np.empty(n, dtype=np.int64)
        number[names] = np.arange(len(names))
        f = number.take(faces)
        valence = self.indptr[names + 1] - self.indptr[names] - 1
        return Patch(names, f, np.bincount(f.ravel()) < valence)

    def _of_rows(self, rows: IntArray) -> IntArray:
        """Numbers of the entries in some rows."""
        first = self.indptr[rows]
        count = self.indptr[rows + 1] - first
        return np.arange(count.sum()) + np.repeat(first - np.cumsum(count) + count, count)


def half_edges_out(edges: HalfEdges, vertices: IntArray) -> tuple[IntArray, Indices]:
    """The place of each half-edge's vertex among some vertices, and the half-edges out of these."""
    half = edges.half.take(edges._of_rows(vertices))
    place = np.repeat(np.arange(len(vertices)), np.diff(edges.indptr)[vertices])
    between = half < edges.faces.size  # the other entries are those of vertices
    return place[between], half[between]


def marked(rows: NDArray[np.integer], n: int) -> BoolArray:
    """Whether each of n vertices is among the given ones; these may be corners of faces, of any shape."""
    mask = np.zeros(n, dtype=bool)
    mask[rows] = True
    return mask


def touching(f: IntArray, mask: BoolArray) -> BoolArray:
    """Whether each face has a marked corner."""
    a, b, c = mask.take(f.T)
    return np.asarray(a | b | c)


def next_corners(corner: NDArray[np.integer]) -> tuple[IntArray, IntArray]:
    """The next and the previous corner of the same face, for corners 3 i + k, and so for half-edges.

    A half-edge runs from the corner after its apex to the one before it.
    """
    k = corner - 3 * (corner // 3)  # faster than the remainder
    after, before = np.where(k == 2, -2, 1), np.where(k == 0, 2, -1)
    return np.asarray(corner + after, dtype=np.int64), np.asarray(corner + before, dtype=np.int64)


def sides(f: IntArray) -> tuple[IntArray, IntArray]:
    """The first and last vertex of each half-edge."""
    return f[:, [1, 2, 0]].ravel(), f[:, [2, 0, 1]].ravel()


def edge_keys(start: IntArray, stop: IntArray, n: int) -> IntArray:
    """A number for each edge, the same in both directions: n times its smaller vertex plus its larger one."""
    return np.minimum(start, stop) * n + np.maximum(start, stop)


def shared_edges(f: IntArray, n: int) -> tuple[IntArray, IntArray, IntArray, IntArray]:
    """Edges of any triangles.

    Their keys in order, the edge of each half-edge, and in pairs the half-edges of those with exactly two faces.
    """
    keys = edge_keys(*sides(f), n)
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    new = np.diff(keys, prepend=-1) > 0
    number = np.cumsum(new) - 1
    edge = np.empty_like(order)
    edge[order] = number
    first, second = order[np.bincount(number)[number] == 2].reshape(-1, 2).T
    return keys[new], edge, first, second


def half_edges_from(f: IntArray, n: int, start: IntArray, stop: IntArray) -> IntArray:
    """Half-edges that run from vertices `start` to `stop`."""
    tail, head = sides(f)
    keys = tail * n + head
    order = np.argsort(keys)
    return order[np.searchsorted(keys, start * n + stop, sorter=order)]


def half_edges(f: IntArray, n: int) -> HalfEdges | None:
    """Half-edges of faces whose indices are in range; None unless each has exactly one twin."""
    faces = f.astype(np.int32)
    back = _numbered(faces, n).T.tocsr()
    there = back.T.tocsr()  # transposing sorts columns, in less time than sorting
    same = np.array_equal(there.indptr, back.indptr) and np.array_equal(there.indices, back.indices)
    if not there.has_canonical_format or not same:
        return None
    diagonal = np.flatnonzero(there.data >= f.size).astype(np.int32)
    return HalfEdges(faces, there.indptr, there.indices, there.data, back.data, diagonal)


def _numbered(faces: Indices, n: int) -> csr_matrix:
    """Numbers of half-edges, then of vertices on the diagonal; columns are unsorted, and an entry may occur twice."""
    loops = np.arange(n, dtype=np.int32)
    a, b, c = np.ascontiguousarray(faces.T)
    start, stop = np.concatenate((b, c, a, loops)), np.concatenate((c, a, b, loops))
    half = np.arange(faces.size, dtype=np.int32).reshape(faces.shape)
    numbers = coo_matrix((np.append(half.T, loops + half.size), (start, stop)), shape=(n, n))
    numbers.has_canonical_format = True  # nothing is to be summed
    return numbers.tocsr()


def components(i: IntArray, j: IntArray, size: int) -> tuple[int, NDArray[np.int32]]:
    """Number of components of a graph given by its edges (i, j), and the component of each vertex."""
    links = coo_matrix((np.ones(len(i), dtype=np.int8), (i, j)), shape=(size, size))
    number, label = connected_components(links, directed=False)
    return int(number), label


def rims(start: NDArray[np.integer], stop: NDArray[np.integer]) -> list[list[int]]:
    """The cycles that edges start -> stop form, each vertex having one edge that leaves it."""
    onward = dict(zip(start.tolist(), stop.tolist(), strict=True))
    found = []
    while onward:
        at, after = onward.popitem()
        rim = [at]
        while after != rim[0]:
            rim.append(after)
            after = onward.pop(after)
        found.append(rim)
    return found[::-1]


def fans(
    f: IntArray, first: NDArray[np.integer], second: NDArray[np.integer]
) -> tuple[int, NDArray[np.int32]]:
    """Number of fans of faces around vertices, and the fan of each corner.

    Faces of one fan are neighbours across half-edges that are paired, either way: `first` and `second`.
    """
    corners = f.ravel()
    (tail, head), (other_tail, other_head) = next_corners(first), next_corners(second)
    same = corners[tail] == corners[other_tail]
    ends = np.where(same, other_tail, other_head), np.where(same, other_head, other_tail)
    return components(np.r_[tail, head], np.r_[ends], f.size)


def pinched_vertices(
    f: IntArray, first: NDArray[np.integer], second: NDArray[np.integer]
) -> IntArray:
    """Vertices with several fans of faces, whose neighbours are paired half-edges."""
    number, fan = fans(f, first, second)
    vertex = np.empty(number, dtype=np.int64)
    vertex[fan] = f.ravel()
    return np.flatnonzero(np.bincount(vertex) > 1)


def direction_components(
    i: IntArray, j: IntArray, clash: NDArray[np.bool_], m: int
) -> NDArray[np.int32]:
    """Components (2, m) of the forward and the backward directions of faces, linked where neighbours i and j agree.

    Neighbours `clash` if both run along their edge the same way. If a face has both of its directions in one component,
    the surface is not orientable.
    """
    _, label = components(
        np.r_[i, i + m], np.r_[np.where(clash, j + m, j), np.where(clash, j, j + m)], 2 * m
    )
    return label.reshape(2, m)
