"""Holes of a surface: the loops of edges around them, and the caps that close them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ..mesh.arrays import TINY, FloatArray, IntArray
from ..mesh.edges import half_edges_from


def simple_rims(rim: Sequence[int], vertex: Sequence[int]) -> Iterator[tuple[list[int], int]]:
    """Split a rim into parts in which no vertex comes twice; return each with the entry that closes it.

    `vertex` has the vertex of each entry. Two holes that touch at a vertex have one rim, which passes the vertex twice;
    its return closes a part. The part's first entry and the entry that closes it share the vertex: the caps of both
    parts and the faces between them make one fan around it. Other entries stay apart, because the cap of one part can't
    close two fans.

    >>> list(simple_rims([10, 11, 12, 13, 14, 15], [0, 1, 2, 0, 3, 4]))
    [([10, 11, 12], 13), ([13, 14, 15], 13)]
    >>> list(simple_rims([10, 11, 12, 13], [0, 1, 0, 1]))
    [([10, 11], 12), ([12, 13], 12)]
    """
    path: list[int] = []
    place: dict[int, int] = {}
    for entry, at in zip(rim, vertex, strict=True):
        if at in place:
            part = path[place[at] :]
            yield part, entry
            place = {key: k for key, k in place.items() if k < place[at]}
            del path[len(path) - len(part) :]
        place[at] = len(path)
        path.append(entry)
    yield path, path[0]


def cap(
    p: FloatArray,
    onward: FloatArray,
    *,
    growth: float = 1.6,
    rings: int = 2,
    smoothings: int = 4,
) -> tuple[FloatArray, IntArray]:
    """New vertices and faces that close a rim of positions (k, 3); new vertices are numbered from k on.

    Rings, each spaced wider by a factor `growth` than the one around it, and a fan inside. The first rings continue the
    surface along the conormals `onward` (k, 3) of the edges from each vertex to the next, averaged over neighbours
    `smoothings` times. A cap bent against the surface along a jagged rim has angles that do not add up to a turn around
    its vertices. The others run to their centre. Triangles at the rim are as large as its edges, which keeps the error
    of the angles there small; a cap has fewer than 8/3 vertices for each edge of the rim. A rim of three edges takes
    one face.
    """
    k = len(p)
    if k == 3:
        return np.empty((0, 3)), np.array([[0, 1, 2]])
    length = np.linalg.norm(np.roll(p, -1, axis=0) - p, axis=1)
    total = float(length.sum())
    if not total > 0:  # all at one point
        length, total = np.ones(k), float(k)
    share = (length + np.roll(length, 1)) / (2 * total)
    at = np.append(0, np.cumsum(length) / total)
    onward = onward + np.roll(onward, 1, axis=0)
    for _ in range(smoothings):
        onward = (np.roll(onward, 1, axis=0) + 2 * onward + np.roll(onward, -1, axis=0)) / 4
    onward = onward / np.maximum(np.linalg.norm(onward, axis=1), TINY)[:, None]
    ring, turn = np.arange(k), at[:-1]
    points: list[FloatArray] = []
    faces: list[IntArray] = []
    number = k
    radius = outer_radius = total / (2 * np.pi)
    spacing = total / k
    # equilateral triangles are .87 high; room for a fan
    while (inner := radius - 0.9 * spacing) > 0.7 * spacing:
        m = round(2 * np.pi * inner / spacing)
        inner_turn = (np.arange(m) + 0.5) / m
        if len(points) < rings:
            p, outer_radius = p + (radius - inner) * onward, inner
        centre, closed = share @ p, np.vstack((p, p[:1]))
        places = np.column_stack([np.interp(inner_turn, at, closed[:, axis]) for axis in range(3)])
        points.append(centre + (places - centre) * (inner / outer_radius))
        inner_ring = np.arange(number, number + m)
        faces.append(_strip(ring, turn, inner_ring, inner_turn))
        ring, turn, radius, number = inner_ring, inner_turn, inner, number + m
        spacing *= growth
    points.append((share @ p)[None])
    faces.append(np.column_stack((ring, np.roll(ring, -1), np.full(len(ring), number))))
    return np.concatenate(points), np.concatenate(faces)


def conormals(v: FloatArray, f: IntArray, a: IntArray, b: IntArray) -> FloatArray:
    """Conormals (k, 3) of boundary edges from a to b, away from their faces b -> a; as long as the edges."""
    half = half_edges_from(f, len(v), b, a)
    edge, out = v[b] - v[a], v[a] - v[f.ravel()[half]]
    square = np.maximum((edge * edge).sum(axis=1), TINY)[:, None]
    out -= (out * edge).sum(axis=1)[:, None] / square * edge
    return np.asarray(
        out * np.sqrt(square) / np.maximum(np.linalg.norm(out, axis=1), TINY)[:, None]
    )


def _strip(a: IntArray, ta: FloatArray, b: IntArray, tb: FloatArray) -> IntArray:
    """Faces between two rings, vertices at fractions ta and tb of a turn: each edge takes the next vertex opposite.

    >>> _strip(np.array([0, 1, 2]), np.array([0, 0.3, 0.6]), np.array([3, 4]), np.array([0.2, 0.7])).tolist()
    [[0, 1, 3], [1, 2, 3], [2, 4, 3], [2, 0, 4], [0, 3, 4]]
    """
    n, m = len(a), len(b)
    order = np.argsort(np.concatenate((ta[1:], ta[:1] + 1, tb[1:], tb[:1] + 1)), kind="stable")
    outer = order < n
    # so far
    i, j = (
        np.cumsum(passed) - passed for passed in (outer.astype(np.int64), (~outer).astype(np.int64))
    )
    return np.column_stack((a[i % n], np.where(outer, a[(i + 1) % n], b[(j + 1) % m]), b[j % m]))
