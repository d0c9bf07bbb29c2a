"""Angles, areas and volume of triangle meshes in space."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import igl
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: Faces that are measured at once: temporaries fit the cache, and calls cost little.
_BLOCK = 1 << 14


def by_blocks(compute: Callable[[FloatArray], NDArray[Any]], x: FloatArray, f: IntArray) -> NDArray[Any]:
    """What `compute` makes of the corners (coordinate, corner, face) of faces, block by block: small temporaries."""
    columns = np.ascontiguousarray(x.T)
    blocks = (f[k : k + _BLOCK].T for k in range(0, max(1, len(f)), _BLOCK))
    return np.concatenate([compute(columns.take(block, axis=1)) for block in blocks])


def sides(corners: FloatArray) -> FloatArray:
    """(3, 3, m): coordinate, corner, face; the side opposite each corner, from the next corner to the one after."""
    side = np.empty_like(corners)
    for k in range(3):
        np.subtract(corners[:, k - 1], corners[:, k - 2], out=side[:, k])
    return side


def area_vectors(side: FloatArray) -> FloatArray:
    """(3, m): normals of the faces with those sides, twice as long as the areas."""
    a, b = side[:, 0], side[:, 1]
    return np.stack((a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]))


def sines_and_cosines(side: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(m,) and (3, m): of the corner angles, both times the lengths of the two sides there."""
    normal = area_vectors(side)
    cosines = [-np.einsum("ij,ij->j", side[:, k - 2], side[:, k - 1]) for k in range(3)]
    return np.sqrt(np.einsum("ij,ij->j", normal, normal)), np.stack(cosines)


def half_cotangents(v: FloatArray, f: IntArray) -> FloatArray:
    """(m, 3) halves of the corner angles' cotangents; not finite on faces of zero area.

    >>> half_cotangents(np.eye(3), np.array([[0, 1, 2]])).round(6)
    array([[0.288675, 0.288675, 0.288675]])
    """
    def compute(corners: FloatArray) -> FloatArray:
        sines, cosines = sines_and_cosines(sides(corners))
        return (cosines / (2 * sines)).T

    with np.errstate(divide="ignore", invalid="ignore"):
        return by_blocks(compute, v, f)


def corner_angles(v: FloatArray, f: IntArray) -> FloatArray:
    """(m, 3) corner angles in radians, finite on degenerate faces, too; a corner with a zero-length side counts as 0.

    >>> np.degrees(corner_angles(np.eye(3), np.array([[0, 1, 2]]))).round(9)
    array([[60., 60., 60.]])
    """
    def compute(corners: FloatArray) -> FloatArray:
        side = sides(corners)
        size = np.abs(side).max(axis=(0, 1))
        side /= np.where(size > 0, size, 1)  # products neither over- nor underflow
        return np.arctan2(*sines_and_cosines(side)).T

    return by_blocks(compute, v, f)


def angle_defects(angles: FloatArray, f: IntArray, n: int) -> FloatArray:
    """Integrated Gaussian curvature of each of `n` vertices: the angle in radians that is missing around it."""
    return np.asarray(2 * np.pi - np.bincount(f.ravel(), angles.ravel(), n))


def log_edges(v: FloatArray, f: IntArray) -> FloatArray:
    """Mean logarithm of the lengths of the edges around each vertex; lengths below 1e-300 count as that."""
    start, end = f.ravel(), f[:, [1, 2, 0]].ravel()
    d = v[start] - v[end]
    log = np.log(np.maximum(np.sqrt(np.einsum("ij,ij->i", d, d)), 1e-300))
    n = len(v)  # a closed mesh runs through every edge once each way
    return np.asarray(np.bincount(start, log, n) / np.bincount(start, minlength=n))


def face_areas(v: FloatArray, f: IntArray) -> FloatArray:
    """Flat areas of the faces.

    >>> face_areas(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=float), np.array([[0, 1, 2]]))
    array([0.5])
    """
    return np.asarray(igl.doublearea(v, f)) / 2


def vertex_areas(v: FloatArray, f: IntArray) -> FloatArray:
    """Area that belongs to each vertex, A_i of eq. (13): a third of the faces around it."""
    return sum_at_vertices(face_areas(v, f) / 3, f, len(v))  # eq. (13)


def sum_at_vertices(values: FloatArray, f: IntArray, n: int) -> FloatArray:
    """Sums of the faces' values around each vertex."""
    return np.asarray(np.bincount(f.ravel(), np.repeat(values, 3), n), float)


def enclosed_volume(v: FloatArray, f: IntArray) -> float:
    """Volume inside a closed surface, negative if its faces are oriented inwards."""
    a, b, c = ((v - v.mean(axis=0))[f[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6
