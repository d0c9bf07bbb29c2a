"""Shaded surfaces in matplotlib, face by face from the back to the front: no display, no OpenGL."""

from __future__ import annotations

from typing import Any

import igl
import numpy as np
from numpy.typing import NDArray

from ...draw.palette import INK

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: Where the light comes from, in the frame of the view.
_LIGHT = np.array([-0.35, 0.45, 0.82]) / np.linalg.norm([-0.35, 0.45, 0.82])
#: What counts as up in files: z or y.
_UP = np.array([0.0, 1.0, 1.0])
#: A vertical axis that is closer to the ground than this is not taken for one.
_LEAST_UP = 0.3


def view_of(v: FloatArray) -> FloatArray:
    """Rotation (3, 3) whose columns are right, up and towards the viewer, so that the longest axis lies across."""
    centred = v - v.mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    # The sign of an axis is that of its third moment, so that the same body is always shown from the same side.
    sign = ((centred @ axes.T) ** 3).sum(axis=0)
    # But up is up in the file: along z or y, whichever the format has.
    if abs(axes[1] @ _UP) > _LEAST_UP:
        sign[1] = axes[1] @ _UP
    axes *= np.where(sign < 0, -1.0, 1.0)[:, None]
    axes[2] *= np.sign(np.linalg.det(axes))
    return axes.T


def shading(v: FloatArray, f: IntArray, view: FloatArray, ambient: float) -> FloatArray:
    """Brightness (m,) of the faces between `ambient`, where the light grazes, and 1."""
    normals = igl.per_face_normals(v @ view, f, np.zeros(3))
    return np.asarray(ambient + (1 - ambient) * np.abs(normals @ _LIGHT))


def draw(ax: Any, v: FloatArray, f: IntArray, colours: FloatArray, view: FloatArray, lines: bool = False) -> None:
    """Draw a closed surface in face colours (m, 3) that are shaded already, with its edges or without."""
    from matplotlib.collections import PolyCollection

    y = v @ view
    order = np.argsort(y[f, 2].mean(axis=1), kind="stable")
    corners = y[f[order], :2]
    rgb = np.clip(colours[order], 0, 1)
    edges = INK if lines else rgb
    ax.add_collection(PolyCollection(list(corners), facecolors=rgb, edgecolors=edges, linewidths=0.2, rasterized=True))
    middle, reach = (y.max(axis=0) + y.min(axis=0)) / 2, np.ptp(y[:, :2], axis=0).max() * 0.52
    ax.set(xlim=(middle[0] - reach, middle[0] + reach), ylim=(middle[1] - reach, middle[1] + reach), aspect="equal")
    ax.axis("off")
