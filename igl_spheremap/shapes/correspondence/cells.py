"""The faces of an overlay: convex cells are cut into triangles, and faces made flat by rounding are taken out."""

from __future__ import annotations

from math import dist

import numpy as np

from ...mesh.arrays import EPS, BoolArray, FloatArray, IntArray
from ...mesh.edges import marked, touching
from ...sphere.rows import row_crosses, row_dots, unit_rows
from .complex import Complex
from .walk import Segments, Triangulation

#: Distances, in units of the largest coordinate, from the rounding of points and of their images.
_ROUNDING = 8 * EPS
#: Sides up to this length are collapsed: rounding moves crossings of nearly coincident edges by as much.
SHORT = 32 * _ROUNDING
#: Twice the area of a face over the square of its longest side: below, the sign depends on the order of operations.
_FLAT = 4 * EPS


def cell_triangles(
    A: Triangulation, B: Triangulation, cut_a: Segments, cut_b: Segments, x: FloatArray
) -> tuple[IntArray, IntArray]:
    """Cut the cells into triangles (m, 3), and return them with the faces (2, m) of A and of B that they are parts of.

    `x` are the nodes' positions. A cell is divided by a fan around its largest angle: no triangle is as flat.
    """
    cell, start, end = _sides(A, B, cut_a, cut_b)
    fresh = np.append(True, cell[1:] != cell[:-1])
    number = np.cumsum(fresh) - 1
    following = np.searchsorted(number * len(x) + start, number * len(x) + end)
    ahead = x[end] - x[start]
    behind = np.empty_like(ahead)
    behind[following] = -ahead
    cosine = row_dots(ahead, behind) / np.sqrt(_squares(ahead) * _squares(behind))
    side = np.lexsort((cosine, number))[fresh]
    cell, centre, side = cell[fresh], start[side], following[side]
    found, cells = [], []
    while len(side):
        fan = end[side] != centre
        cell, centre, side = cell[fan], centre[fan], side[fan]
        found.append(np.column_stack((centre, start[side], end[side])))
        cells.append(cell)
        side = following[side]
    return np.concatenate(found), np.stack(np.divmod(np.concatenate(cells), len(B.f)))


def _sides(A: Triangulation, B: Triangulation, cut_a: Segments, cut_b: Segments) -> list[IntArray]:
    """Return cell, start and end of each side of the cells, counter-clockwise, in the order of cells and starts.

    They are the segments of A and B, from both of their sides. Cells have the number of A's face times B's faces, plus
    B's face.
    """
    own = ~cut_b.along  # the others are segments of A, too
    g, h, p, q = A.forward[cut_a.edge], B.forward[cut_b.edge[own]], cut_a.half, cut_b.half[own]
    back = np.where(cut_a.along, B.twin[p], p)
    face_a = np.concatenate((g, A.twin[g], q, q)) // 3
    face_b = np.concatenate((p, back, h, B.twin[h])) // 3
    start = np.concatenate((cut_a.start, cut_a.end, cut_b.start[own], cut_b.end[own]))
    end = np.concatenate((cut_a.end, cut_a.start, cut_b.end[own], cut_b.start[own]))
    cell = face_a * len(B.f) + face_b
    order = np.lexsort((start, cell))
    return [each[order] for each in (cell, start, end)]


class Coincidences:
    """A refinement in floating point, in which nodes within rounding of each other are merged.

    The refinement comes from exact signs, but its nodes are rounded. If float64 can't tell nodes, or a node and an
    edge, apart, a face between them may come out flat or negative. If that leaves fewer such faces, the collapse of a
    side as short as rounding takes the face out.

    Attributes
    ----------
    faces : (m, 3) int64 array
        The faces; `left` marks the present ones.
    owners : (2, m) int64 array
        The face of A and of B that each is a part of.
    on : (2, k, 3) float64 array
        The nodes on A and on B, in each one's own unit.
    node : (k,) int64 array
        The node that each has become.
    """

    def __init__(
        self,
        faces: IntArray,
        owners: IntArray,
        on: FloatArray,
        surfaces: tuple[FloatArray, FloatArray],
        vertices: tuple[IntArray, IntArray],
    ) -> None:
        self.faces, self.owners, self.on = faces, owners, on
        self.left, self.node = np.ones(len(faces), dtype=bool), np.arange(len(on[0]))
        self._normals = tuple(_normals(surface) for surface in surfaces)
        self._vertex = tuple(marked(rows, len(self.node)) for rows in vertices)

    def merge(self) -> int:
        """Take flat faces out by collapses, and count the others."""
        n, flat = len(self.node), np.flatnonzero(self._flat(self.faces, self.owners))
        beside = touching(self.faces, marked(self.faces[flat], n))
        self._whole = marked(self.faces[beside], n)  # nodes whose faces are all in the complex
        near = np.flatnonzero(touching(self.faces, self._whole))
        corners = map(tuple, self.faces[near].tolist())
        self._complex = Complex(dict(zip(near.tolist(), corners, strict=True)))
        self._bad = set(flat.tolist())
        while any([self._collapse(i) for i in flat.tolist() if i in self._bad]):
            pass
        kept = list(self._complex.faces)
        self.left[near], self.left[kept] = False, True
        self.faces[kept] = np.reshape(list(self._complex.faces.values()), (-1, 3))
        return len(self._bad)

    def _flat(self, faces: IntArray, owners: IntArray) -> BoolArray:
        """Say which faces are flat: not positive on a surface though their whole face is not flat, or with a side as
        short as rounding on both surfaces."""
        flat, square = np.zeros(len(faces), dtype=bool), np.zeros((3, len(faces)))
        for p, normals, owner in zip(self.on, self._normals, owners, strict=True):
            a, b, c = p[faces].transpose(1, 0, 2)
            normal = normals[owner]
            own = np.stack([_squares(side) for side in (b - a, c - b, a - c)])
            positive = row_dots(row_crosses(b - a, c - a), normal) > _FLAT * own.max(axis=0)
            flat |= ~positive & normal.any(axis=1)
            square = np.maximum(square, own)
        return flat | (square.min(axis=0) <= _ROUNDING**2)

    def _distance(self, v: int, w: int) -> float:
        """Measure the larger distance of two nodes on both surfaces."""
        return max(dist(p[v].tolist(), p[w].tolist()) for p in self.on)

    def _collapse(self, i: int) -> bool:
        """If the shortest side of a face is as short as rounding, collapse it; say whether it did."""
        a, b, c = self._complex.faces[i]
        length, v, w = min((self._distance(v, w), v, w) for v, w in ((a, b), (b, c), (c, a)))
        first, second = ([fixed[u] for fixed in self._vertex] for u in (v, w))
        if length > SHORT or (first[0] and second[0]) or (first[1] and second[1]):
            return False
        if any(first) and any(second):
            if second[0]:
                return self._onto(v, w)
            return self._onto(w, v)  # the vertex of A stays
        return (not any(second) and self._onto(w, v)) or (not any(first) and self._onto(v, w))

    def _onto(self, out: int, into: int) -> bool:
        """If that leaves fewer flat faces, move one end of a side to the other, which ends the side."""
        if not (self._whole[[out, into]].all() and (edit := self._complex.collapsed(out, into))):
            return False
        faces, gone = edit
        rows, old = np.array(list(faces)), self.on[:, into].copy()
        for p, fixed in zip(self.on, self._vertex, strict=True):
            if fixed[out]:
                p[into] = p[out]
        flat = self._flat(np.array(list(faces.values())), self.owners[:, rows])
        before = self._bad & {*faces, *gone}
        if flat.sum() >= len(before):
            self.on[:, into] = old
            return False
        self._complex.put(faces, gone)
        self._bad = self._bad - before | set(rows[flat].tolist())
        for fixed in self._vertex:
            fixed[into] |= fixed[out]
        self.node[self.node == out] = into
        return True

    def join_points(self) -> tuple[int, int]:
        """Join nodes of negative faces on each surface, and count the faces without area on A and on B.

        Whole limbs of one surface may lie in one point of the other: their faces have no area there.
        """
        faces, owners = self.faces[self.left], self.owners[:, self.left]
        first, second = (
            _join(self.on[k], faces, self._normals[k][owners[k]], self._vertex[k]) for k in (0, 1)
        )
        return first, second


def _join(p: FloatArray, faces: IntArray, normals: FloatArray, held: BoolArray) -> int:
    """Join ends of sides as short as rounding, in place, while faces are negative; count those without area."""
    place, some = np.arange(len(p)), True
    while some:
        corners = p[faces]
        twice = row_dots(
            row_crosses(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), normals
        )
        negative = faces[twice < 0]
        ends = np.stack((negative, np.roll(negative, -1, axis=1)), axis=2)
        square = _squares(p[ends[..., 0]] - p[ends[..., 1]])
        square[held[place[ends]].all(axis=2)] = np.inf
        side = square.argmin(axis=1)
        short = ends[np.arange(len(ends)), side][square.min(axis=1, initial=np.inf) <= SHORT**2]
        some = False
        for pair in short.tolist():
            first, second = place[pair].tolist()
            if first != second and not (held[first] and held[second]):
                kept, gone = second, first
                if held[first]:
                    kept, gone = first, second
                members = place == gone
                place[members], p[members], some = kept, p[kept], True
    return int((twice <= 0).sum())


def _normals(surface: FloatArray) -> FloatArray:
    """Compute unit normals of faces (m, 3, 3); if rounding would decide them, zeros."""
    a, b, c = surface.transpose(1, 0, 2)
    normals = row_crosses(b - a, c - a)
    longest = np.sqrt(np.max([_squares(side) for side in (b - a, c - b, a - c)], axis=0))
    normals[np.sqrt(_squares(normals)) <= _ROUNDING / 4 * np.abs(surface).max() * longest] = 0
    return unit_rows(normals)


def _squares(d: FloatArray) -> FloatArray:
    return np.einsum("...i,...i->...", d, d)
