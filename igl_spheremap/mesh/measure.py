"""Angles, areas, normals and volume of triangle meshes in space."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import igl
import numpy as np
from numpy.typing import NDArray

from .arrays import EPS, HALF_DIGITS, TINY, FloatArray, IntArray, own_unit

#: Sides below this are multiplied in units of the face: libigl's product of four lengths underflows.
_SHORT = 1e-70
#: Next to coordinates of size 1, edges below this length have less than three digits in float64.
FLOAT64_LIMIT = float(512 * EPS)


def by_blocks(
    compute: Callable[[FloatArray], NDArray[Any]], x: FloatArray, f: IntArray, block: int = 1 << 14
) -> NDArray[Any]:
    """Apply `compute` to the corners (coordinate, corner, face) of faces, block by block: temporaries fit the cache."""
    columns = np.ascontiguousarray(x.T)
    found = []
    for k in range(0, max(1, len(f)), block):
        found.append(compute(columns.take(f[k : k + block].T, axis=1)))
    return np.concatenate(found)


def by_libigl(
    measure: Callable[..., NDArray[Any]], v: FloatArray, f: IntArray, block: int = 999
) -> FloatArray:
    """Apply a function of libigl, which measures each face independently, block by block.

    From 1,000 faces on libigl starts threads, which take longer than they save.
    """
    blocks = np.split(f, range(block, len(f), block))
    return np.concatenate(list(map(partial(measure, v), blocks)))


def spread(n: int, most: int) -> slice:
    """Slice that takes at most that many of `n` items, evenly spaced.

    >>> list(range(10))[spread(10, 4)]
    [0, 3, 6, 9]
    """
    return slice(None, None, max(1, -(-n // most)))


def weighted_quantile(values: FloatArray, weights: FloatArray, share: float = 0.5) -> float:
    """The smallest value up to which that share of the weights lies: their median by default.

    >>> weighted_quantile(np.array([3.0, 1.0, 2.0]), np.array([5.0, 1.0, 1.0]))
    3.0
    """
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order[np.searchsorted(total, total[-1] * share)]])


def _unit_scale(d: FloatArray) -> FloatArray:
    """Rows divided by their largest entry, so that products neither over- nor underflow."""
    size = np.abs(d).max(axis=1, keepdims=True)
    return np.asarray(d / np.where(size > 0, size, 1))


def corner_angles(v: FloatArray, f: IntArray) -> FloatArray:
    """(m, 3) corner angles in radians, finite even on degenerate faces; a corner with a zero-length side counts as 0.

    >>> np.degrees(corner_angles(np.eye(3), np.array([[0, 1, 2]]))).round(9)
    array([[60., 60., 60.]])
    """
    angles = by_libigl(igl.internal_angles, v, f)
    wrong = ~(np.abs(angles[:, 0] + angles[:, 1] + angles[:, 2] - np.pi) < HALF_DIGITS)
    if not wrong.any():
        return angles
    redo = np.flatnonzero(wrong)  # sides of length 0, or products beyond float64
    for k in range(3):
        a, b, c = (v[f[redo, (k + j) % 3]] for j in range(3))
        u, w = _unit_scale(b - a), _unit_scale(c - a)
        angles[redo, k] = np.arctan2(
            np.linalg.norm(np.cross(u, w), axis=1), np.einsum("ij,ij->i", u, w)
        )
    return angles


def angle_defects(angles: FloatArray, f: IntArray, n: int) -> FloatArray:
    """Integrated Gaussian curvature of each of `n` vertices: the angle in radians that is missing around it."""
    return np.asarray(2 * np.pi - np.bincount(f.ravel(), angles.ravel(), n))


def log_edges(v: FloatArray, f: IntArray) -> FloatArray:
    """Mean logarithm of the lengths of the edges around each vertex; no length counts as less than the least float."""
    start, end = f.ravel(), f[:, [1, 2, 0]].ravel()
    d = v.take(start, axis=0) - v.take(end, axis=0)
    square, least = np.einsum("ij,ij->i", d, d), TINY
    log = np.log(np.maximum(np.sqrt(square), least))
    fine = square < least / EPS  # squares that underflow
    if fine.any():
        size = np.maximum(np.abs(d[fine]).max(axis=1), least)
        log[fine] = np.log(size) + np.log(
            np.maximum(np.linalg.norm(d[fine] / size[:, None], axis=1), 1)
        )
    n = len(v)  # a closed mesh runs through every edge once each way
    return np.asarray(np.bincount(start, log, n) / np.bincount(start, minlength=n))


def face_areas(v: FloatArray, f: IntArray) -> FloatArray:
    """Flat areas of the faces.

    >>> face_areas(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=float), np.array([[0, 1, 2]]))
    array([0.5])
    """
    areas = np.asarray(igl.doublearea(v, f)) / 2
    small = np.flatnonzero(areas < _SHORT**2)
    if len(small):
        size, unit = _in_own_units(v, f[small])
        areas[small] = np.where(size < _SHORT, size**2 * unit, areas[small])
    return areas


def log_face_areas(v: FloatArray, f: IntArray) -> FloatArray:
    """Logarithms of the flat areas of the faces, finite even for areas below the least float.

    >>> log_face_areas(1e-200 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]])).round(3)
    array([-921.727])
    """
    areas = face_areas(v, f)
    small = np.flatnonzero(areas < _SHORT**2)
    with np.errstate(divide="ignore"):
        logs = np.log(areas)
        size, unit = _in_own_units(v, f[small])
        logs[small] = 2 * np.log(size) + np.log(unit)
    return logs


def _in_own_units(v: FloatArray, f: IntArray) -> tuple[FloatArray, FloatArray]:
    """A length of each face, and its area in units of that length."""
    a, b, c = (v[f[:, k]] for k in range(3))
    sides = np.stack((b - a, c - a))
    size = np.abs(sides).max(axis=(0, 2))
    u, w = sides / np.where(size > 0, size, 1)[:, None]
    return size, np.linalg.norm(np.cross(u, w), axis=1) / 2


def surface_area(v: FloatArray, f: IntArray) -> float:
    """Flat area of all faces together."""
    return float(face_areas(v, f).sum())


def vertex_areas(v: FloatArray, f: IntArray) -> FloatArray:
    """Area of each vertex, A_i of eq. (13): libigl's barycentric mass matrix, which is diagonal."""
    areas = np.asarray(igl.massmatrix(v, f, igl.MASSMATRIX_TYPE_BARYCENTRIC).diagonal())  # eq. (13)
    if (areas < _SHORT**2).any():
        return vertex_shares(face_areas(v, f), f, len(v))
    return areas


def log_vertex_areas(v: FloatArray, f: IntArray) -> FloatArray:
    """Logarithms of `vertex_areas`, finite even below the least float."""
    areas = vertex_areas(v, f)
    if (areas >= _SHORT**2).all():
        return np.log(areas)
    corners, logs, largest = f.ravel(), np.repeat(log_face_areas(v, f), 3), np.full(len(v), -np.inf)
    np.maximum.at(largest, corners, logs)
    known = np.where(np.isfinite(largest), largest, 0.0)
    with np.errstate(divide="ignore"):
        return np.asarray(
            known + np.log(np.bincount(corners, np.exp(logs - known[corners]), len(v)) / 3)
        )


def vertex_shares(areas: FloatArray, f: IntArray, n: int) -> FloatArray:
    """Areas of `n` vertices: each face gives a third of its area to each corner, as in `vertex_areas`."""
    return np.asarray(np.bincount(f.ravel(), np.repeat(areas / 3, 3), n))


def enclosed_volume(v: FloatArray, f: IntArray) -> float:
    """Volume inside a closed surface, negative if its faces are oriented inwards."""
    a, b, c = ((v - v.mean(axis=0))[f[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6


def inside_out(v: FloatArray, f: IntArray) -> bool:
    """Say whether the faces of a closed surface point inwards: its volume is below 0 by more than rounding.

    A volume below a billionth of the cube of the extent is rounding: a flat surface encloses none.
    """
    own = own_unit(v)[0]
    return bool(enclosed_volume(own, f) < -1e-9 * np.ptp(own, axis=0).max() ** 3)


def vertex_normals(v: FloatArray, f: IntArray) -> FloatArray:
    """Area-weighted unit normals at the vertices: the Gauss map."""
    return fill_directions(area_normals(v, f), f)


def area_normals(v: FloatArray, f: IntArray) -> FloatArray:
    """libigl's normals at the vertices; without direction if all faces around have no area."""
    # Definition 1
    return np.asarray(igl.per_vertex_normals(v, f, igl.PER_VERTEX_NORMALS_WEIGHTING_TYPE_AREA))


def without_direction(x: FloatArray) -> NDArray[np.bool_]:
    """Rows that are zero, not finite, or too short for float64."""
    length = np.sqrt(np.einsum("ij,ij->i", x, x))
    return ~((length > np.sqrt(TINY)) & (length < np.inf))  # the square of less underflows


def fill_directions(x: FloatArray, f: IntArray) -> FloatArray:
    """Unit rows along those of `x`; rows without direction take the mean of their neighbours', ring by ring.

    If nothing has a direction, all get the z axis.
    """
    length, known = np.sqrt(np.einsum("ij,ij->i", x, x)), ~without_direction(x)
    if known.all():
        return x / length[:, None]
    x = np.where(known[:, None], x / np.where(known, length, 1)[:, None], 0.0)
    edges = np.vstack((f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]))
    while not known.all():
        reach = edges[known[edges[:, 0]] & ~known[edges[:, 1]]]
        if not len(reach):
            x[~known] = [0.0, 0.0, 1.0]
            break
        total = np.column_stack(
            [np.bincount(reach[:, 1], x[reach[:, 0], k], minlength=len(x)) for k in range(3)]
        )
        new = np.unique(reach[:, 1])
        size = np.linalg.norm(total[new], axis=1)
        flat = size < 4096 * EPS  # rounding, of up to so many unit vectors
        if flat.any():  # opposite neighbours cancel: any one of them will do then
            _, first = np.unique(reach[:, 1], return_index=True)
            total[new[flat]] = x[reach[first[flat], 0]]
        x[new] = total[new] / np.linalg.norm(total[new], axis=1, keepdims=True)
        known[new] = True
    return x


def rounding_notes(v: FloatArray, f: IntArray, share: float = 0.01) -> list[str]:
    """A note on float32 positions that, far from the origin, are rounded by more than this share of an edge.

    >>> v, f = 4e6 + np.eye(3) / 3, np.array([[0, 1, 2]])
    >>> len(rounding_notes(v, f)), len(rounding_notes(np.float32(v).astype(float), f))
    (0, 1)
    """
    step = float(np.spacing(np.float32(min(np.abs(v).max(), np.finfo(np.float32).max))))
    sample = f[spread(len(f), 1000)]
    edge = float(np.median(np.linalg.norm(v[sample] - v[np.roll(sample, 1, axis=1)], axis=2)))
    if step <= share * edge or (v != v.astype(np.float32)).any():
        return []
    return [
        f"positions are float32 and far from the origin: they are rounded to {step:.2g}, and edges are "
        f"about {edge:.2g} long; move the body to the origin before it is saved, or save it in float64"
    ]
