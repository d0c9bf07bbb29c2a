"""The faces of an overlay: convex cells cut into triangles, and cells thinner than rounding taken out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..mesh.arrays import FloatArray, IntArray
from ..mesh.edges import components
from ..sphere.rows import row_crosses, row_dots, unit_rows
from .walk import Segments, Triangulation

#: Distances, in units of the largest coordinate, that come out of the rounding of points and of their images.
_ROUNDING = 8 * np.finfo(float).eps
#: Rounds of moves at most.
_ROUNDS = 40


@dataclass(frozen=True, eq=False)
class Sides:
    """The sides of cells, counter-clockwise; a cell is the intersection of a face of A and one of B.

    Attributes
    ----------
    cell, start, end : (k,) int64 arrays
        The cell and the nodes of each side, in the order of cells and starts.
    """

    cell: IntArray
    start: IntArray
    end: IntArray

    @classmethod
    def of(cls, A: Triangulation, B: Triangulation, cut_a: Segments, cut_b: Segments) -> Sides:
        """All segments from both of their sides; cells have the number of A's face times B's faces, plus B's face."""
        own = ~cut_b.along  # the others are segments of A, too
        g, h, p, q = A.forward[cut_a.edge], B.forward[cut_b.edge[own]], cut_a.half, cut_b.half[own]
        back = np.where(cut_a.along, B.twin[p], p)
        face_a, face_b = np.concatenate((g, A.twin[g], q, q)) // 3, np.concatenate((p, back, h, B.twin[h])) // 3
        start = np.concatenate((cut_a.start, cut_a.end, cut_b.start[own], cut_b.end[own]))
        end = np.concatenate((cut_a.end, cut_a.start, cut_b.end[own], cut_b.start[own]))
        return cls(face_a * len(B.f) + face_b, start, end)._sorted()

    def _sorted(self) -> Sides:
        order = np.lexsort((self.start, self.cell))
        return Sides(self.cell[order], self.start[order], self.end[order])

    def merged(self, node: IntArray) -> Sides:
        """The sides that are left where nodes are replaced by others; two of a cell that run back and forth go."""
        start, end = node[self.start], node[self.end]
        there = start * len(node) + end
        back = end * len(node) + start
        order = np.lexsort((np.minimum(there, back), self.cell))
        low, cell = np.minimum(there, back)[order], self.cell[order]
        same = (low[1:] == low[:-1]) & (cell[1:] == cell[:-1])
        keep = start != end
        keep[order] &= ~(np.append(same, False) | np.append(False, same))
        return Sides(self.cell[keep], start[keep], end[keep])._sorted()

    def triangles(self, x: FloatArray) -> tuple[IntArray, IntArray]:
        """Triangles that make up the cells, (m, 3), and the cell of each; `x` are the nodes' positions."""
        fresh = np.append(True, self.cell[1:] != self.cell[:-1])
        number = np.cumsum(fresh) - 1
        following = np.searchsorted(number * len(x) + self.start, number * len(x) + self.end)
        # A fan around the largest angle has no triangle that is as flat.
        ahead = x[self.end] - x[self.start]
        behind = np.empty_like(ahead)
        behind[following] = -ahead
        cosine = row_dots(ahead, behind) / np.sqrt(_squares(ahead) * _squares(behind))
        side = np.lexsort((cosine, number))[fresh]
        cell, centre, side = self.cell[fresh], self.start[side], following[side]
        found, owners = [], []
        while len(side):
            fan = self.end[side] != centre
            cell, centre, side = cell[fan], centre[fan], side[fan]
            found.append(np.stack((centre, self.start[side], self.end[side]), axis=1))
            owners.append(cell)
            side = following[side]
        return np.concatenate(found), np.concatenate(owners)


def merge_close(faces: IntArray, least: FloatArray, x: FloatArray, on_a: FloatArray, on_b: FloatArray, own: IntArray,
                other: IntArray) -> IntArray:
    """The node that takes the place of each, where faces between edges that nearly coincide are as thin as rounding.

    A face goes if its area is below its `least` one, and two of its corners are as good as one on the sphere, on A or
    on B. No two vertices of A, which have the numbers `own`, are merged, and no two of B, `other`; `on_b` is changed so
    that these keep their positions.
    """
    n = len(x)
    node, left, rows = np.arange(n), np.ones(len(faces), dtype=bool), np.arange(len(faces))
    vertices_b, single, shapes = on_b[other], (own, other), (x, on_a, on_b)
    while True:
        rows = rows[_areas(x, node[faces[rows]]) < least[rows]]
        corners = node[faces[rows]]
        ends = np.stack((corners, np.roll(corners, -1, axis=1)), axis=2)
        gap = np.min([_squares(p[ends[..., 0]] - p[ends[..., 1]]) / np.abs(p).max() ** 2 for p in shapes], axis=0)
        closest = gap.argmin(axis=1)
        every = np.arange(len(ends))
        shortest = ends[every, closest][gap[every, closest] <= _ROUNDING**2]
        while True:
            _, group = components(shortest[:, 0], shortest[:, 1], n)
            refused = np.zeros(n, dtype=bool)
            for nodes in single:
                refused[np.bincount(group[np.unique(node[nodes])], minlength=n) > 1] = True
            new = np.full(n, n)
            np.minimum.at(new, group, np.arange(n))
            new = new[group]
            merged = np.bincount(new, minlength=n)[new] > 1
            touched = np.flatnonzero(left & merged[node[faces]].any(axis=1))
            corners = new[node[faces[touched]]]
            flat = (corners == np.roll(corners, -1, axis=1)).any(axis=1)
            sides, times = np.unique(_sides(corners[~flat], n), return_counts=True)
            double = sides[times > 1]  # beside one of these, faces would be folded together
            refused[group[double // n]] = refused[group[double % n]] = True
            keep = ~refused[group[shortest[:, 0]]]
            if keep.all():
                break
            shortest = shortest[keep]
        if not len(shortest):
            return node
        node = new[node]
        on_b[node[other]] = vertices_b
        left[touched[flat]] = False
        rows = touched[~flat]


def nudge(p: FloatArray, faces: IntArray, surface: FloatArray, owners: IntArray, fixed: IntArray) -> None:
    """Move nodes on a surface by some rounding errors, in place, so that faces are positive that rounding made flat.

    `surface` are the corners (m, 3, 3) of the surface's faces, `owners` those that faces are parts of. Each one that
    is not positive asks for the least moves of its corners that give it a height above rounding; where several move a
    node, their moves are averaged. Faces as small as what `merge_close` takes for one point stay as they are.
    """
    height = _ROUNDING / 4 * np.abs(p).max()
    movable = np.ones(len(p), dtype=bool)
    movable[fixed] = False
    a, b, c = surface.transpose(1, 0, 2)
    normals = row_crosses(b - a, c - a)
    length = np.sqrt(row_dots(normals, normals))
    normals[length <= height * np.sqrt(np.max([_squares(side) for side in (b - a, c - b, a - c)], axis=0))] = 0
    normals = unit_rows(normals)
    rows = np.arange(len(faces))
    for _ in range(_ROUNDS):
        f, normal = faces[rows], normals[owners[rows]]
        sides = np.stack([p[f[:, k - 1]] - p[f[:, k - 2]] for k in range(3)])
        twice = row_dots(row_crosses(sides[1], sides[2]), normal)
        longest = np.sqrt(_squares(sides).max(axis=0))
        bad = (twice <= 0) & (longest > 4 * height) & normal.any(axis=1)
        f, normal, sides, longest = f[bad], normal[bad], sides[:, bad], longest[bad]
        free = movable[f.T]
        share = (2 * height * longest - twice[bad]) / np.maximum((_squares(sides) * free).sum(axis=0), height**2)
        share = np.minimum(share, 4 * height / longest)  # where only a corner far from the others may move
        moves = np.zeros_like(p)
        for k in range(3):
            np.add.at(moves, f[:, k], (share * free[k])[:, None] * row_crosses(normal, sides[k]))
        count = np.bincount(f.ravel(), minlength=len(p))
        moved = np.flatnonzero(count)
        p[moved] += moves[moved] / count[moved, None]
        rows = np.flatnonzero((count > 0)[faces].any(axis=1))
        if not len(rows):
            break


def _sides(f: IntArray, n: int) -> IntArray:
    """A number for each half-edge of faces."""
    return (f * n + np.roll(f, -1, axis=1)).ravel()


def _areas(x: FloatArray, f: IntArray) -> FloatArray:
    """Areas of flat triangles; libigl's lengths of sides lose those of thin ones."""
    a, b, c = (x[f[:, k]] for k in range(3))
    return np.sqrt(_squares(row_crosses(b - a, c - a))) / 2


def _squares(d: FloatArray) -> FloatArray:
    return np.einsum("...i,...i->...", d, d)
