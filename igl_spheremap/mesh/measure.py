"""Angles, areas and volume of triangle meshes in space."""

from __future__ import annotations

import igl
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def sides(x: FloatArray, f: IntArray) -> FloatArray:
    """(3, 3, m): coordinate, corner, face; the side opposite each corner, from the next corner to the one after."""
    p = x.T.take(f.T, axis=1)
    return np.stack((p[:, 2] - p[:, 1], p[:, 0] - p[:, 2], p[:, 1] - p[:, 0]), axis=1)


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
    sines, cosines = sines_and_cosines(sides(v, f))
    with np.errstate(divide="ignore", invalid="ignore"):
        return (cosines / (2 * sines)).T


def corner_angles(v: FloatArray, f: IntArray) -> FloatArray:
    """(m, 3) corner angles in radians, finite on degenerate faces, too; a corner with a zero-length side counts as 0.

    >>> np.degrees(corner_angles(np.eye(3), np.array([[0, 1, 2]]))).round(9)
    array([[60., 60., 60.]])
    """
    side = sides(v, f)
    size = np.abs(side).max(axis=(0, 1), initial=0.0)
    side /= np.where(size > 0, size, 1)  # products neither over- nor underflow
    return np.ascontiguousarray(np.arctan2(*sines_and_cosines(side)).T)


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
