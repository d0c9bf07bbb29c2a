"""Slivers unfolded by moves about as short as they are thin, before any vertex is removed.

A thin face folds when a vertex crosses its long side by a tiny distance. For each folding the shortest move of its
corners is computed that gives it a small positive area; where several foldings move a vertex, their moves are averaged.
These are projections onto half-spaces; the iteration ends in their intersection if it is not empty.
"""

from __future__ import annotations

import numpy as np

from ..mesh.arrays import BoolArray, FloatArray, IntArray
from ..sphere.rows import row_crosses, row_dets, row_dots, unit_rows
from ..verify.signs import folded_faces
from .embedding import Watch, dilate

#: Twice the area that a folding is to get, in units of its longest side squared.
_THICKNESS = 1e-3
#: Moves are longer than the shortest sufficient ones by this factor.
_OVER_RELAXATION = 1.3
#: Iterations without progress after which it ends.
_PATIENCE = 25
#: Rings of vertices around foldings that may move.
_RINGS = 3


def nudge(x: FloatArray, f: IntArray, watch: Watch | None = None) -> FloatArray:
    """Unfold faces by small moves of the vertices around them, where that succeeds.

    Agmon 1954, *The Relaxation Method for Linear Inequalities*.

    >>> x = unit_rows(np.array([[0.1, 0, 1], [-0.1, 0, 1], [0, 0.2, 1], [0, 1e-6, 1], [0, -0.2, 1.0]]))
    >>> f = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 4], [3, 1, 4]])
    >>> folded_faces(x, f).tolist(), bool(folded_faces(nudge(x, f), f).any())
    ([False, True, False, False], False)
    """
    bad = folded_faces(x, f)
    near = np.zeros(len(x), dtype=bool)
    near[f[bad]] = True
    near = dilate(f, near, _RINGS)
    y, folded = x, f[bad]
    f = f[near[f].any(axis=1)]
    best, fewest, since = x, len(folded), 0
    while fewest and since < _PATIENCE:
        y = _projected(y, folded, near)
        if watch is not None:
            watch(y)
        folded = f[folded_faces(y, f)]
        best, fewest, since = (y, len(folded), 0) if len(folded) < fewest else (best, fewest, since + 1)
    return _without_failures(x, best, f)


def _without_failures(x: FloatArray, y: FloatArray, f: IntArray) -> FloatArray:
    """The moves from `x` to `y` but for those connected to foldings that are left."""
    moved = (x != y).any(axis=1)
    failed = np.zeros(len(x), dtype=bool)
    failed[f[folded_faces(y, f)]] = True
    while True:
        grown = failed | (dilate(f, failed, 1) & moved)
        if grown.sum() == failed.sum():
            return np.where(failed[:, None], x, y)
        failed = grown


def _projected(x: FloatArray, folded: IntArray, movable: BoolArray) -> FloatArray:
    """One step of all foldings towards a little area each."""
    p = [x.take(folded[:, k], axis=0) for k in range(3)]
    outward = p[0] + p[1] + p[2]
    reach = np.sqrt(row_dots(outward, outward))
    outward /= np.where(reach > 0, reach, 1.0)[:, None]
    side = [p[(k + 2) % 3] - p[(k + 1) % 3] for k in range(3)]
    square = np.stack([row_dots(s, s) for s in side])
    slope = [row_crosses(outward, s) for s in side]  # of twice the area, as each corner moves
    lack = _THICKNESS * square.max(axis=0) - row_dets(outward, side[1], side[2])
    length = lack / np.maximum(square.sum(axis=0), 1e-300)
    move, count = np.zeros_like(x), np.bincount(folded.ravel(), minlength=len(x))
    for k in range(3):
        np.add.at(move, folded[:, k], length[:, None] * slope[k])
    moved = np.flatnonzero((count > 0) & movable)
    y = x.copy()
    y[moved] = unit_rows(x[moved] + _OVER_RELAXATION * move[moved] / count[moved, None])
    return y
