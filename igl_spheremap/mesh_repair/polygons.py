"""Polygons cut into triangles that keep their shape, in any plane: fans where these are right, ears elsewhere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError
from ..mesh.arrays import (
    BoolArray,
    FloatArray,
    IntArray,
    check_triangles,
    is_padded,
    own_unit,
    plain_array,
    plural,
)
from ..mesh.edges import edge_keys
from ..sphere.rows import plane_crosses
from . import SIX_DIGITS


def triangulated(v: FloatArray, f: ArrayLike) -> tuple[IntArray, IntArray, tuple[str, ...]]:
    """Faces as triangles, the row of `f` that each comes from, and the action: arrays of polygons are cut.

    >>> v = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    >>> faces, row, done = triangulated(v, [[0, 1, 2, 3]])
    >>> faces.tolist(), row.tolist(), done
    ([[0, 1, 2], [0, 2, 3]], [0, 0], ('triangulated 1 polygon',))
    """
    if not len(v):
        raise MeshError("no vertices: the mesh is empty; give a closed triangle mesh")
    polygons = polygons_in(f)
    if polygons is None:
        faces = check_triangles(f)
        return faces, np.arange(len(faces)), ()
    corners, sizes = polygons
    cut = cut_polygons(v, corners, sizes)
    done = triangulation(int((sizes > 3).sum()), int(cut.concave.sum()))
    return corners[cut.triangles], cut.polygon, done


def triangulation(polygons: int, concave: int) -> tuple[str, ...]:
    """The action on polygons, if there were any."""
    if not polygons:
        return ()
    done = f"triangulated {plural(polygons, 'polygon')}"
    if concave:
        done = f"{done}, {concave} of them concave"
    return (done,)


def polygons_in(f: ArrayLike) -> tuple[IntArray, IntArray] | None:
    """The corners in one row, and the number of each face's, of an array of polygons; None of triangles and others.

    Rows of four or more indices, or as VTK and PyVista keep them: before each face's corners their number.
    """
    array = plain_array(f, "faces")
    if array.dtype.kind not in "iu" or not array.size or is_padded(array):
        return None
    if array.ndim == 2 and array.shape[1] > 3 and len(array) != 3:
        if (array[:, 0] == array.shape[1] - 1).all():
            array = array[:, 1:]
        return array.astype(np.int64).ravel(), np.full(len(array), array.shape[1])
    if array.ndim != 1:
        return None
    return counted_corners(array, least=3)


def counted_corners(numbers: IntArray, least: int = 0) -> tuple[IntArray, IntArray] | None:
    """The corners in one row, and their number for each face, which stands before the face's corners.

    If numbers are left over, or a face has fewer than `least` corners, None.
    """
    if is_padded(numbers):
        rows = numbers.reshape(-1, 4).astype(np.int64)
        return rows[:, 1:].ravel(), rows[:, 0]
    heads, at = [], 0
    while at < len(numbers) and numbers[at] >= least:
        heads.append(at)
        at += int(numbers[at]) + 1
    if at != len(numbers):
        return None
    return np.delete(numbers, heads).astype(np.int64), numbers[heads].astype(np.int64)


@dataclass(frozen=True, eq=False)
class CutPolygons:
    """Triangles (k, 3) as places among the corners of polygons, and the polygon of each, in the order of polygons.

    `concave` (m,) marks polygons with a corner that turns inwards.
    """

    triangles: IntArray
    polygon: IntArray
    concave: BoolArray


def cut_polygons(v: FloatArray, corners: IntArray, sizes: IntArray) -> CutPolygons:
    """Cut polygons, all corners in one row and the number of each one's, into triangles.

    All triangles of a polygon face the same way, and no new edge joins two vertices that an edge joins already. If a
    fan about the first or the second corner does so, it is taken; else ears are cut off, the best-shaped first.

    >>> v = np.array([[1, 0, 0], [0, -0.5, 0], [-1, 0, 0], [0, -2, 0]])
    >>> cut = cut_polygons(v, np.arange(4), np.array([4]))
    >>> cut.triangles.tolist(), cut.concave.tolist()
    ([[1, 2, 3], [1, 3, 0]], [True])
    """
    first, m, n = np.cumsum(sizes) - sizes, len(sizes), len(v)
    polygon, place = np.repeat(np.arange(m), sizes), np.arange(len(corners))
    after, before = place + 1, place - 1
    after[first + sizes - 1], before[first] = first, first + sizes - 1
    # whoever checks the faces refuses indices beyond
    p = own_unit(v)[0].take(corners, axis=0, mode="clip")
    p = p - p[first][polygon]
    normal = np.add.reduceat(np.cross(p, p[after]), first)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    turns_in = _shape(p, np.column_stack((before, place, after)), normal[polygon])
    # triangles of fans: the polygon of each, and whether its last side is a new edge
    fan = np.repeat(np.arange(m), sizes - 2)
    step = np.arange(len(fan)) - np.repeat(np.cumsum(sizes - 2) - sizes + 2, sizes - 2)
    inner, fans, sound = step < sizes[fan] - 3, [], np.empty((2, m), dtype=bool)
    for about in (0, 1):
        around = (0 * step, step + 1, step + 2)
        fans.append(np.column_stack([first[fan] + (about + k) % sizes[fan] for k in around]))
        wrong = ~(_shape(p, fans[about], normal[fan]) > SIX_DIGITS)
        sound[about] = np.bincount(fan[wrong], minlength=m) == 0
    sound[:, sizes == 3] = [[True], [False]]  # triangles stay as they are
    edges, left = edge_keys(corners, corners[after], n), np.ones(m, dtype=bool)
    triangles, owner = [np.empty((0, 3), dtype=np.int64)], [np.empty(0, dtype=np.int64)]
    for choices in (1, 2):  # those without a choice choose first
        for about in (0, 1):
            ours = left & sound[about] & (sound.sum(axis=0) <= choices)
            if not ours.any():
                continue
            new = inner & ours[fan]
            a, _, b = corners[fans[about][new]].T
            keys = edge_keys(a, b, n)
            _, index, count = np.unique(
                np.append(keys, edges), return_inverse=True, return_counts=True
            )
            ours[fan[new][count[index[: len(keys)]] > 1]] = False  # the edge is there
            triangles.append(fans[about][ours[fan]])
            owner.append(fan[ours[fan]])
            edges, left = np.append(edges, keys[ours[fan[new]]]), left & ~ours
    taken = set[int]()
    if left.any():
        taken = set(edges.tolist())
    for k in np.flatnonzero(left).tolist():
        places = np.arange(first[k], first[k] + sizes[k])
        ears = _ears(_in_plane(p[places], normal[k]), corners[places].tolist(), taken, n)
        triangles.append(places[np.array(ears)])
        owner.append(np.full(sizes[k] - 2, k))
    order = np.argsort(np.concatenate(owner), kind="stable")
    return CutPolygons(
        np.concatenate(triangles)[order],
        np.concatenate(owner)[order],
        np.logical_or.reduceat(turns_in < -SIX_DIGITS, first),
    )


def _shape(p: FloatArray, triangles: IntArray, normal: FloatArray) -> FloatArray:
    """Twice the area over the square of the longest side, negative for a triangle against its normal."""
    a, b, c = (p[triangles[:, k]] for k in range(3))
    longest = np.max([np.square(side).sum(axis=1) for side in (b - a, c - b, a - c)], axis=0)
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), normal) / longest


def _in_plane(p: FloatArray, normal: FloatArray) -> FloatArray:
    """Positions (k, 2) in the plane across a normal."""
    along = np.cross(np.eye(3)[np.argmin(np.abs(normal))], normal)
    along /= np.linalg.norm(along)
    return np.column_stack((p @ along, p @ np.cross(normal, along)))


def _ears(p: FloatArray, corners: list[int], taken: set[int], n: int) -> list[list[int]]:
    """Triangles (k - 2, 3) of places within a polygon: its ears are cut off, the best first.

    An ear is a corner that turns outwards, with its neighbours, if no other corner is among them. `taken` are the keys
    of edges that are there.
    """
    ring = list(range(len(corners)))

    def ear(k: int) -> list[int]:
        return [ring[k - 1], ring[k], ring[(k + 1) % len(ring)]]

    def key(k: int) -> int:
        before, _, after = ear(k)
        low, high = sorted((corners[before], corners[after]))
        return low * n + high

    def score(k: int) -> float:
        """Merit of cutting a corner: the shape of its ear, best with a new edge, worst without an ear."""
        a, b, c = p[ear(k)]
        longest = max(float(side @ side) for side in (b - a, c - b, a - c))
        shape = 0.0
        if longest:
            shape = float(plane_crosses(b - a, c - a)) / longest
        if not shape > SIX_DIGITS:
            return -1 + min(shape, 0.0)
        others = p[ring]
        others = others[(others != a).any(axis=1) & (others != b).any(axis=1)]
        others = others[(others != c).any(axis=1)]
        within = np.ones(len(others), dtype=bool)
        for start, stop in ((a, b), (b, c), (c, a)):
            within &= plane_crosses(stop - start, others - start) > -SIX_DIGITS * longest
        if within.any():
            return shape - 1
        found = shape + 1
        if key(k) in taken:
            found -= 1
        return found

    scores, triangles = list(map(score, ring)), []
    while len(ring) > 3:
        tip = int(np.argmax(scores))
        triangles.append(ear(tip))
        taken.add(key(tip))
        del ring[tip], scores[tip]
        for k in (tip - 1, tip % len(ring)):
            scores[k] = score(k)
    return [*triangles, ear(0)]
