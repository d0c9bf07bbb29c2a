"""Intrinsic Delaunay triangulation by edge flips, with a bound on their number."""

from __future__ import annotations

import numpy as np

from ..mesh.arrays import ROUNDING, FloatArray, IntArray
from ..mesh.edges import HalfEdges, next_corners


def delaunay_triangulation(
    lengths: FloatArray, edges: HalfEdges, rounds: int = 400, flips_per_face: int = 6
) -> tuple[FloatArray, IntArray]:
    """Flip edges of a closed mesh until opposite angles sum to pi at most: lengths and faces of the same surface.

    `lengths` belong to the edges opposite the corners. Edges may become loops, or join the same vertices as others do.
    Rounding can flip edges back and forth for ever. So rounds, in each of which flipped edges share no face, and flips
    are bounded; if the bounds end it, the other edges stay as they are.

    Fisher, Springborn, Schroeder, Bobenko 2007, *An Algorithm for the Construction of Intrinsic Delaunay
    Triangulations*. (libigl's function for it does not end where edge lengths span many orders of magnitude.)
    """
    lengths, f, twin = lengths.copy(), edges.faces.astype(np.int64), edges.twins().astype(np.int64)
    changed = np.arange(len(f))
    flips_left = flips_per_face * len(f) + 100_000  # small meshes may take more, it costs little
    for _ in range(rounds):
        h = _flippable(lengths, twin, changed)
        flips_left -= len(h)
        if not len(h) or flips_left < 0:
            break
        _flip(lengths, f, twin, h)
        changed = np.concatenate((h // 3, twin[3 * (h // 3) + 1] // 3))
    return lengths, f


def _flippable(lengths: FloatArray, twin: IntArray, faces: IntArray) -> IntArray:
    """Half-edges that violate the Delaunay condition, no two of one face."""
    h = (3 * faces[:, None] + np.arange(3)).ravel()
    h = np.unique(np.minimum(h, twin[h]))
    g = twin[h]
    (sine, cosine), (other_sine, other_cosine) = _angle(lengths, h), _angle(lengths, g)
    sine_of_sum = sine * other_cosine + cosine * other_sine
    h = h[(sine_of_sum < -ROUNDING) & (h // 3 != g // 3)]  # else rounding may flip an edge back
    pair = np.stack((h, twin[h])) // 3
    first = np.full(len(lengths), len(h))
    np.minimum.at(first, pair, np.broadcast_to(np.arange(len(h)), pair.shape))
    return h[(first[pair] == np.arange(len(h))).all(axis=0)]


def _angle(lengths: FloatArray, h: IntArray) -> tuple[FloatArray, FloatArray]:
    """Sine and cosine of the angle opposite a half-edge."""
    x, y = _apex(lengths, h)
    b = lengths.ravel()[h]
    dot, cross = x * (x - b) + y * y, b * y
    length = np.hypot(dot, cross)
    return cross / length, dot / length


def _apex(lengths: FloatArray, h: IntArray) -> tuple[FloatArray, FloatArray]:
    """The opposite corner, as the half-edge runs from the origin along the first axis and its face is above."""
    flat = lengths.ravel()
    after, before = next_corners(h)
    # |edge|, from its end to the apex, from the apex to its start
    b, c, a = flat[h], flat[after], flat[before]
    x = (b + (a - c) * (a + c) / b) / 2
    sides = np.sort(np.stack((a, b, c)), axis=0)  # Kahan's stable area
    s, m, w = sides
    square = (w + (m + s)) * (s - (w - m)) * (s + (w - m)) * (w + (m - s))
    return x, np.sqrt(np.maximum(square, 0)) / (2 * b)


def _flip(lengths: FloatArray, f: IntArray, twin: IntArray, h: IntArray) -> None:
    """Flip edges in place, no two of one face."""
    g = twin[h]
    (h1, h2), (g1, g2) = next_corners(h), next_corners(g)
    t, s = h // 3, g // 3
    (x, y), (u, w) = _apex(lengths, h), _apex(lengths, g)
    length = np.hypot(x - (lengths.ravel()[h] - u), y + w)
    corner, flat = f.ravel(), lengths.ravel()
    i, a, j, b = corner[h], corner[h1], corner[g], corner[g1]
    # Faces (i, a, b) and (j, b, a) become (i, a, j) and (j, b, i). The outer edges move:
    old = np.concatenate((g1, h2, h1, g2))
    new = np.concatenate((3 * t, 3 * t + 2, 3 * s, 3 * s + 2))
    outer, moved = flat[old], np.arange(len(twin))
    moved[old] = new
    across = moved[twin[old]]
    flat[new] = outer
    twin[new], twin[across] = across, new
    for face, corners, inner in ((t, (i, a, j), 3 * s + 1), (s, (j, b, i), 3 * t + 1)):
        f[face] = np.stack(corners, axis=1)
        flat[3 * face + 1] = length
        twin[3 * face + 1] = inner
