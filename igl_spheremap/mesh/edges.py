"""The half-edges of a closed mesh: the pattern of its sparse matrices, and the messages for edges that do not fit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import connected_components

from ..errors import MeshError
from .arrays import IntArray, count, examples, listed

Indices = NDArray[np.int32]
#: The call that repairs a fault. The command line prints it as the flags that stand for it.
REPAIR = "repair_mesh(v, f)"
REPAIR_LARGEST = "repair_mesh(v, f, keep_largest=True)"


@dataclass(frozen=True, eq=False)
class HalfEdges:
    """Pattern, in compressed rows with sorted columns, of matrices with an entry for each edge and each vertex.

    Half-edge 3 i + k runs along the side of face i that is opposite corner k. On the diagonal `half` and `twin` are
    beyond the last half-edge.

    Attributes
    ----------
    faces : (m, 3) int32 array
        A copy of the faces.
    indptr, indices : int32 arrays
        The pattern, as of `scipy.sparse.csr_matrix`.
    half : (6 n - 12 + n,) int32 array
        Of each entry, the half-edge that runs from its row to its column.
    twin : (6 n - 12 + n,) int32 array
        The half-edge that runs back.
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


def edge_keys(start: IntArray, stop: IntArray, n: int) -> IntArray:
    """A number for each edge, the same in both directions: n times its smaller vertex plus its larger one."""
    return np.minimum(start, stop) * n + np.maximum(start, stop)


def half_edges(f: IntArray, n: int) -> HalfEdges | None:
    """Half-edges of faces whose indices are in range; None unless each has exactly one twin."""
    faces = f.astype(np.int32)
    there = _numbered(faces, n)
    back = there.T.tocsr()
    same = np.array_equal(there.indptr, back.indptr) and np.array_equal(there.indices, back.indices)
    if there.nnz < f.size + n or not same:
        return None
    there.data -= 1
    back.data -= 1
    diagonal = np.flatnonzero(there.data >= f.size).astype(np.int32)
    return HalfEdges(faces, there.indptr, there.indices, there.data, back.data, diagonal)


def _numbered(faces: Indices, n: int) -> csr_matrix:
    """Matrix of the numbers of half-edges, from 1, then of vertices on the diagonal; those of one entry are added."""
    loops = np.arange(n, dtype=np.int32)
    a, b, c = np.ascontiguousarray(faces.T)
    start, stop = np.concatenate((b, c, a, loops)), np.concatenate((c, a, b, loops))
    number = np.append(np.arange(faces.size, dtype=np.int32).reshape(faces.shape).T, loops + faces.size) + 1
    return csr_matrix((number, (start, stop)), shape=(n, n))


def components(i: IntArray, j: IntArray, size: int) -> tuple[int, NDArray[np.int32]]:
    """Number of components of a graph given by its edges (i, j), and the component of each vertex."""
    links = coo_matrix((np.ones(len(i), dtype=np.int8), (i, j)), shape=(size, size))
    number, label = connected_components(links, directed=False)
    return int(number), label


def direction_components(i: IntArray, j: IntArray, clash: NDArray[np.bool_], m: int) -> NDArray[np.int32]:
    """Components (2, m) of the forward and the backward directions of faces, linked where neighbours i and j agree.

    If a face has both of its directions in one component, the surface is not orientable.
    """
    _, label = components(np.r_[i, i + m], np.r_[np.where(clash, j + m, j), np.where(clash, j, j + m)], 2 * m)
    return label.reshape(2, m)


def explain_characteristic(f: IntArray, twin: NDArray[np.int32], n: int) -> NoReturn:
    """Raise for pinched vertices, else for handles."""
    # A fan is a class of half-edges with one tail; half-edge h goes on to the next one of its twin.
    m = len(f)
    onward = 3 * (twin // 3) + (twin + 1) % 3
    _, label = components(np.arange(3 * m), onward, 3 * m)
    fan_vertex = np.empty(label.max() + 1, dtype=np.int64)
    fan_vertex[label] = np.roll(f, -1, axis=1).ravel()
    fans = np.bincount(fan_vertex, minlength=n)
    genus = (2 - (len(fan_vertex) - 3 * m // 2 + m)) // 2
    if (fans > 1).any():
        bad = np.flatnonzero(fans > 1)
        raise MeshError(f"non-manifold vertex: {count(bad, 'vertex', 'vertices')} where two sheets touch, "
                        f"{examples(bad)}; give each sheet a vertex of its own")
    raise MeshError(f"genus {genus}: the surface has {genus} handle{'s' * (genus > 1)} (Euler characteristic "
                    f"{2 - 2 * genus}, everywhere, not at one place); only genus 0 maps to a sphere: cut and fill "
                    "the handles")


def explain_edges(f: IntArray, n: int) -> NoReturn:
    """Raise the error that fits a mesh whose edges are not all shared by two opposite faces."""
    start, stop = f.ravel(), f[:, [1, 2, 0]].ravel()
    edge, inverse, faces_at = np.unique(edge_keys(start, stop, n), return_inverse=True, return_counts=True)
    ends = np.column_stack((edge // n, edge % n))
    if (faces_at > 2).any():
        bad = ends[faces_at > 2]
        _, first, copies = np.unique(np.sort(f, axis=1), axis=0, return_index=True, return_counts=True)
        twice = first[copies > 1]
        hint = f"{count(twice, 'face')} given twice, {examples(twice)}: remove the copies ({REPAIR} does)" if len(
            twice) else "split the surface there, or remove the surplus faces"
        raise MeshError(f"non-manifold edge: {count(bad, 'edge')} in more than two faces, {edge_list(bad)}; {hint}")
    if (faces_at < 2).any():
        bad = np.column_stack((start, stop))[faces_at[inverse] < 2]
        raise MeshError(f"open surface: {count(bad, 'boundary edge')}, {edge_list(bad)}; close the holes, "
                        f"or weld coincident vertices if it is a triangle soup ({REPAIR} does)")
    order = np.argsort(inverse, kind="stable")
    first, second = order[0::2], order[1::2]
    clash = start[first] == start[second]
    bad = ends[inverse[first[clash]]]
    faces = np.column_stack((first // 3, second // 3))[clash]
    forward, backward = direction_components(first // 3, second // 3, clash, len(f))
    if (forward == backward).any():
        raise MeshError(f"not orientable: no choice of face directions agrees across all edges (a Klein bottle or "
                        f"projective plane), it fails {edge_list(bad[:1])}; give an orientable surface")
    raise MeshError(f"inconsistent orientation: {count(bad, 'edge')} run in the same direction by both faces, e.g. "
                    f"faces {listed(faces[0])} at edge {bad[0, 0]}-{bad[0, 1]}; reverse faces until they agree "
                    f"({REPAIR} does)")


def edge_list(edges: NDArray[Any]) -> str:
    return "e.g. " + ", ".join(f"{int(i)}-{int(j)}" for i, j in edges[:3])


def explain_half_edges(f: IntArray, n: int) -> NoReturn:
    repeated = (f[:, 0] == f[:, 1]) | (f[:, 1] == f[:, 2]) | (f[:, 2] == f[:, 0])
    if repeated.any():
        bad = np.flatnonzero(repeated)
        raise MeshError(f"degenerate: {count(bad, 'face')} with a repeated vertex index, {examples(bad)}; "
                        f"remove them ({REPAIR} does)")
    explain_edges(f, n)
