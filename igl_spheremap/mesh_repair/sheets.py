"""Sheets that meet in edges of more than two faces: which faces go on into which, and a vertex for each sheet there."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..mesh.arrays import BoolArray, FloatArray, IntArray
from ..mesh.edges import components, next_corners, shared_edges, sides
from ..mesh.measure import enclosed_volume

#: Rounds of pairing at most: an edge that is still non-manifold after bodies were separated joins them in the next
#: round, which may make neighbouring edges non-manifold. Of 300 random bodies of voxels none took more than two.
_ROUNDS = 4


@dataclass(frozen=True, eq=False)
class PartedSheets:
    """Faces, at most two at each edge, the input's row of each vertex, and how many edges were parted."""

    f: IntArray
    owner: IntArray
    edges: int


def part_sheets(v: FloatArray, f: IntArray) -> PartedSheets | None:
    """Part sheets that meet in edges of an even number of faces; None if there is no such edge, or it can't be done.

    A sheet with two faces at an edge goes on from one into the other. Where a sheet touches itself, its faces are
    sorted by angle around the edge, and neighbours with the body between them are paired, which separates bodies that
    touch; where the edge stays non-manifold, neighbours with nothing between them. Paired faces agree in direction.
    """
    (start, stop), n = sides(f), len(v)
    _, edge, first, second = shared_edges(f, n)
    count = np.bincount(edge)
    nonmanifold = np.flatnonzero(count[edge] > 2)
    if not len(nonmanifold) or (count[count > 2] % 2).any():
        return None
    sheets, sheet = components(first // 3, second // 3, len(f))
    pairs = nonmanifold[np.lexsort((sheet[nonmanifold // 3], edge[nonmanifold]))].reshape(-1, 2)
    by_angles = (
        np.unique(edge[nonmanifold] * sheets + sheet[nonmanifold // 3], return_counts=True)[1] != 2
    ).any()
    at = np.zeros(n, dtype=bool)
    at[start[nonmanifold]] = at[stop[nonmanifold]] = True
    joined = np.zeros(len(count), dtype=bool)
    for _ in range(_ROUNDS if by_angles else 1):
        if by_angles:
            found = _paired_by_angles(v, f, nonmanifold, edge, joined)
            if found is None:
                return None
            pairs = found
        parted = _with_pairs(f, n, at, np.r_[first, pairs[:, 0]], np.r_[second, pairs[:, 1]])
        new = shared_edges(parted.f, len(parted.owner))[1]
        left = np.unique(edge[np.bincount(new)[new] > 2])
        if not len(left):
            return replace(parted, edges=int((count > 2).sum()))
        joined[left] ^= True
    return None


def _paired_by_angles(
    v: FloatArray, f: IntArray, half: IntArray, edge: IntArray, joined: BoolArray
) -> IntArray | None:
    """Pairs (k, 2) of half-edges at non-manifold edges, by angles of faces; None unless directions alternate."""
    start, stop, third = (vertices[half] for vertices in (*sides(f), f.ravel()))
    up = start < stop
    a, b = np.minimum(start, stop), np.maximum(start, stop)
    axis = v[b] - v[a]
    axis = axis / np.maximum(np.linalg.norm(axis, axis=1), np.finfo(np.float64).tiny)[:, None]
    side = v[third] - v[a]
    _, first, group = np.unique(edge[half], return_index=True, return_inverse=True)
    zero = side - (side * axis).sum(axis=1)[:, None] * axis
    zero = zero[first][group]
    angle = np.arctan2((side * np.cross(axis, zero)).sum(axis=1), (side * zero).sum(axis=1))
    order = np.lexsort((angle, group))
    # Around an edge, counterclockwise as seen from its end, a face that runs down has the body before it.
    down = ~up[order]
    begin = np.searchsorted(group[order], group[order])
    position = np.arange(len(order)) - begin
    if enclosed_volume(v, f) < 0:
        down = ~down
    opens = down ^ joined[edge[half[order]]]
    if (opens != (opens[begin] ^ (position % 2 == 1))).any():
        return None
    size = np.bincount(group)[group[order]]
    after = begin + (position + 1) % size
    return np.column_stack((half[order[opens]], half[order[after[opens]]]))


def _with_pairs(
    f: IntArray, n: int, at: BoolArray, first: IntArray, second: IntArray
) -> PartedSheets:
    """Give each fan of faces a vertex of its own at the vertices `at`; paired half-edges are neighbours."""
    start = f.ravel()
    (tail, head), (other_tail, other_head) = next_corners(first), next_corners(second)
    same = start[tail] == start[other_tail]
    ends = np.where(same, other_tail, other_head), np.where(same, other_head, other_tail)
    _, fan = components(np.r_[tail, head], np.r_[ends], f.size)
    _, sheet = components(first // 3, second // 3, len(f))
    smaller = -np.bincount(sheet)[sheet].repeat(3)  # the largest sheet keeps the input's rows
    corner = np.flatnonzero(at[start])
    _, one, index = np.unique(fan[corner], return_index=True, return_inverse=True)
    one = corner[one]
    order = np.lexsort((one, smaller[one], start[one]))
    extra = np.append(False, start[one[order[1:]]] == start[one[order[:-1]]])
    number = np.empty(len(one), dtype=np.int64)
    number[order] = np.where(extra, n - 1 + np.cumsum(extra), start[one[order]])
    parted = start.copy()
    parted[corner] = number[index]
    return PartedSheets(parted.reshape(-1, 3), np.append(np.arange(n), start[one[order[extra]]]), 0)
