"""Shaded surfaces as pixels, by numpy alone: no display, no OpenGL."""

from __future__ import annotations

import igl
import numpy as np
from numpy.typing import NDArray

from ..mesh.arrays import FloatArray, IntArray

#: Where the light comes from, in the frame of the view.
LIGHT = np.array([-0.35, 0.45, 0.82]) / np.linalg.norm([-0.35, 0.45, 0.82])
#: What counts as up in files: z or y.
_UP = np.array([0.0, 1.0, 1.0])
#: The body's second axis is taken for vertical, and turned upwards, if the sum of its y and z is larger than this.
_LEAST_UP = 0.3
_MARGIN = 1.06  # half the side of a picture, in half the body's longer side


def view_of(v: FloatArray) -> FloatArray:
    """Rotation (3, 3) whose columns are right, up and towards the viewer, so that the longest axis lies across."""
    centred = v - v.mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    # The sign of an axis is that of its third moment, so that the same body is always shown from the same side.
    sign = ((centred @ axes.T) ** 3).sum(axis=0)
    # But up in the picture is up in the file: along z or y, whichever the format has.
    if abs(axes[1] @ _UP) > _LEAST_UP:
        sign[1] = axes[1] @ _UP
    axes *= np.where(sign < 0, -1.0, 1.0)[:, None]
    axes[2] *= np.sign(np.linalg.det(axes))
    return axes.T


def shading(v: FloatArray, f: IntArray, view: FloatArray, ambient: float) -> FloatArray:
    """Brightness (m,) of the faces between `ambient`, where the light grazes, and 1."""
    normals = igl.per_face_normals(v @ view, f, np.zeros(3))
    return np.asarray(ambient + (1 - ambient) * np.abs(normals @ LIGHT))


def raster(y: FloatArray, f: IntArray, colours: FloatArray, size: int) -> NDArray[np.uint8]:
    """A picture (size, size, 3) of a surface in face colours (m, 3), seen along -z and fitted into the square.

    >>> triangle = np.array([[-1.0, -1, 0], [1, -1, 0], [0, 1, 0]])
    >>> raster(triangle, np.array([[0, 1, 2]]), np.array([[1.0, 0, 0]]), 9)[4, 4].tolist()
    [255, 0, 0]
    """
    low, high = y.min(axis=0), y.max(axis=0)
    radius = max(float((high - low)[:2].max()) / 2, 1e-300) * _MARGIN
    pixels = (y - (low + high) / 2) * (size / (2 * radius)) * [1, -1, 1] + [size / 2, size / 2, 0]
    place, depth, owner = _samples(pixels, f, size)
    levels = np.ptp(depth) / np.iinfo(np.uint16).max or 1.0  # integers of 16 bits are sorted in a tenth of the time
    front = np.argsort(((depth - depth.min()) / levels).astype(np.uint16), kind="stable")
    seen = np.full(size * size, len(f))  # white, where there is no face
    seen[place[front]] = owner[front]  # of equal places the last assignment counts
    palette = np.rint(255 * np.clip(np.vstack((colours, np.ones(3))), 0, 1)).astype(np.uint8)
    return palette[seen].reshape(size, size, 3)


def _samples(pixels: FloatArray, f: IntArray, size: int) -> tuple[IntArray, FloatArray, IntArray]:
    """Places in the picture, depths and faces of points that lie less than a pixel apart on every face."""
    corners = pixels[f]
    longest = np.abs(corners - corners[:, [1, 2, 0]])[:, :, :2].max(axis=(1, 2))
    level = np.ceil(np.log2(np.maximum(longest, 0.5))).astype(int)
    parts = []
    for k in np.unique(level):
        faces = np.flatnonzero(level == k)
        x, y, depth = (corners[faces, :, axis] @ _grid(int(2.0**k)).T for axis in range(3))
        column, row = (np.clip(pixel, 0, size - 1).astype(np.int32) for pixel in (x, y))
        parts.append((row * size + column, depth, np.broadcast_to(faces[:, None], row.shape)))
    place, depth, owner = (np.concatenate([part[j].ravel() for part in parts]) for j in range(3))
    return place, depth, owner


def _grid(k: int) -> FloatArray:
    """Barycentric coordinates of the points that divide a triangle's edges into `k` parts; of its middle for 0.

    >>> _grid(0), len(_grid(1)), len(_grid(2))
    (array([[0.33333333, 0.33333333, 0.33333333]]), 3, 6)
    """
    if k == 0:
        return np.full((1, 3), 1 / 3)
    i, j = (index.ravel() for index in np.mgrid[: k + 1, : k + 1])
    inside = i + j <= k
    i, j = i[inside], j[inside]
    return np.column_stack((i, j, k - i - j)) / k
