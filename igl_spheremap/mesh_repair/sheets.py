"""Sheets that meet in edges of more than two faces: which faces go on into which, and a vertex for each sheet there."""

from __future__ import annotations

import numpy as np

from ..mesh.arrays import TINY, BoolArray, FloatArray, IntArray
from ..mesh.edges import components, fans, marked, shared_edges, sides
from ..mesh.measure import enclosed_volume


def part_sheets(v: FloatArray, f: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Part the sheets that meet in edges of more than two faces.

    Return faces, at most two at each edge, and the rows of the input that the vertices and the faces come from.

    At each edge faces are paired, those that run along it with those that run against it. A sheet that has two faces
    there goes on from one into the other. Other faces are sorted by angle around the edge: where directions alternate,
    neighbours with the body between them are paired, which separates bodies that touch. If the edge stays non-manifold,
    neighbours with nothing between them are paired. If directions don't alternate, the straightest pairs are taken.
    Left-over faces, and those of edges that stay non-manifold, are dropped.
    """
    faces = np.arange(len(f))
    while True:
        parted, owner, surplus = _parted(v, f[faces])
        if not len(surplus):
            return parted, owner, faces
        faces = np.delete(faces, surplus)


def _parted(v: FloatArray, f: IntArray, rounds: int = 4) -> tuple[IntArray, IntArray, IntArray]:
    """Faces with a vertex for each sheet, the row of each vertex, and the faces that have no pair somewhere.

    An edge that is still non-manifold after bodies were separated joins them in the next of some rounds, which may make
    neighbouring edges non-manifold.
    """
    (start, stop), n = sides(f), len(v)
    _, edge, first, second = shared_edges(f, n)
    count = np.bincount(edge)
    half = np.flatnonzero(count[edge] > 2)
    none = np.empty(0, dtype=np.int64)
    if not len(half):
        return f, np.arange(n), none
    at = marked(np.r_[start[half], stop[half]], n)
    sheets, sheet = components(first // 3, second // 3, len(f))
    _, index, faces = np.unique(
        edge[half] * sheets + sheet[half // 3], return_inverse=True, return_counts=True
    )
    crowded = marked(edge[half[faces[index] != 2]], len(count))
    alone = half[~crowded[edge[half]]]
    by_sheets = alone[np.lexsort((sheet[alone // 3], edge[alone]))].reshape(-1, 2)
    rest = half[crowded[edge[half]]]
    joined = np.zeros(len(count), dtype=bool)
    for _ in range(rounds):
        pairs = np.concatenate((by_sheets, _paired_by_angles(v, f, rest, edge, joined)))
        unpaired = np.setdiff1d(half, pairs)
        if len(unpaired):
            return f, none, np.unique(unpaired // 3)
        parted, owner = _with_pairs(f, n, at, np.r_[first, pairs[:, 0]], np.r_[second, pairs[:, 1]])
        new = shared_edges(parted, len(owner))[1]
        left = np.bincount(new)[new] > 2
        if not left.any():
            return parted, owner, none
        joined[np.unique(edge[left])] ^= True
    return f, none, np.unique(np.flatnonzero(left) // 3)


def _paired_by_angles(
    v: FloatArray, f: IntArray, half: IntArray, edge: IntArray, joined: BoolArray
) -> IntArray:
    """Pairs (k, 2) of half-edges at non-manifold edges, one each way, by angles of faces around the edge."""
    none = np.empty((0, 2), dtype=np.int64)
    if not len(half):
        return none
    start, stop, third = (vertices[half] for vertices in (*sides(f), f.ravel()))
    up = start < stop
    a, b = np.minimum(start, stop), np.maximum(start, stop)
    axis = v[b] - v[a]
    axis = axis / np.maximum(np.linalg.norm(axis, axis=1), TINY)[:, None]
    side = v[third] - v[a]
    _, first, group = np.unique(edge[half], return_index=True, return_inverse=True)
    zero = side - (side * axis).sum(axis=1)[:, None] * axis
    zero = zero[first][group]
    angle = np.arctan2((side * np.cross(axis, zero)).sum(axis=1), (side * zero).sum(axis=1))
    pairs, inside_out = [none], enclosed_volume(v, f) < 0
    order = np.lexsort((angle, group))
    for one in np.split(order, np.flatnonzero(np.diff(group[order])) + 1):
        apart = not joined[edge[half[one[0]]]]
        # Around an edge, counterclockwise as seen from its end, a face that runs down has the body before it.
        opens = up[one] ^ inside_out ^ apart
        if len(one) % 2 == 0 and (opens != np.roll(opens, 1)).all():
            k = np.flatnonzero(opens)
            pairs.append(half[np.column_stack((one[k], one[(k + 1) % len(one)]))])
        else:
            pairs.append(half[one[_straightest(angle[one], up[one], apart)]])
    return np.concatenate(pairs)


def _straightest(angle: FloatArray, up: BoolArray, most: bool) -> IntArray:
    """Pairs (k, 2) of faces around an edge, one each way, the straightest first, or the most bent."""
    i, j = (each.ravel() for each in np.meshgrid(np.flatnonzero(up), np.flatnonzero(~up)))
    bend = np.abs(np.pi - np.abs(angle[i] - angle[j]))
    if not most:
        bend = -bend
    pairs: list[tuple[int, int]] = []
    free = np.ones(len(up), dtype=bool)
    for k in np.argsort(bend, kind="stable").tolist():
        if free[i[k]] and free[j[k]]:
            free[[i[k], j[k]]] = False
            pairs.append((int(i[k]), int(j[k])))
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def _with_pairs(
    f: IntArray, n: int, at: BoolArray, first: IntArray, second: IntArray
) -> tuple[IntArray, IntArray]:
    """Give each fan of faces a vertex of its own at the vertices `at`; paired half-edges are neighbours."""
    start, fan = f.ravel(), fans(f, first, second)[1]
    _, sheet = components(first // 3, second // 3, len(f))
    smaller = -np.bincount(sheet)[sheet].repeat(3)  # the largest sheet keeps the input's rows
    corner = np.flatnonzero(at[start])
    _, one, index = np.unique(fan[corner], return_index=True, return_inverse=True)
    one = corner[one]
    order = np.lexsort((one, smaller[one], start[one]))
    owner = start[one[order]]
    number = np.empty(len(one), dtype=np.int64)
    number[order], extra = numbered(owner, n)
    parted = start.copy()
    parted[corner] = number[index]
    return parted.reshape(-1, 3), np.append(np.arange(n), owner[extra])


def numbered(owner: IntArray, n: int) -> tuple[IntArray, BoolArray]:
    """Numbers of fans, given the vertex of each: the first fan keeps the vertex's, the others come from n on.

    >>> numbered(np.array([4, 0, 4]), 5)[0].tolist()
    [4, 0, 5]
    """
    extra = ~marked(np.unique(owner, return_index=True)[1], len(owner))
    return np.where(extra, n + np.cumsum(extra) - 1, owner), extra
