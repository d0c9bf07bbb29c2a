"""Steps that keep every face's exact sign: a map free of foldings stays so."""

from __future__ import annotations

import numpy as np

from ..mesh.arrays import BoolArray, FloatArray, IntArray
from ..sphere.rows import unit_rows
from ..verify.signs import folded_faces
from .energy import Energy

#: A face is refused if its energy exceeds this many times its old one plus this many times the mean of equal area.
_GROWTH, _OF_MEAN = 3.0, 10.0
#: Vertices of refused faces halve their moves this often at most; if faces are refused still, the step is too long.
_HALVINGS = 8


def certified_step(energy: Energy, x: FloatArray, move: FloatArray,
                   before: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """The map x + move and its energy by face; None if some face is still refused in the end.

    Vertices of refused faces shorten their own moves, so that single faces do not shorten the whole step.
    """
    f, area = energy.source.f, energy.source.area
    limit = _GROWTH * before + _OF_MEAN * area * (before.sum() / area.sum())
    y = unit_rows(x + move)
    after = energy.by_face(y)
    refused = _refused(y, f, after, limit)
    share = np.ones(len(x))
    for _ in range(_HALVINGS):
        if not refused.any():
            return y, after
        moved = np.zeros(len(x), dtype=bool)
        moved[f[refused]] = True
        share[moved] /= 2
        y[moved] = unit_rows(x[moved] + share[moved, None] * move[moved])
        near = np.flatnonzero(moved[f].any(axis=1))
        after[near] = energy.by_face(y, near)
        refused[near] = _refused(y, f[near], after[near], limit[near])
    return None if refused.any() else (y, after)


def _refused(y: FloatArray, f: IntArray, after: FloatArray, limit: FloatArray) -> BoolArray:
    """Faces that are folded, by exact arithmetic, or grow beyond their limit."""
    return ~(after < limit) | folded_faces(y, f)
