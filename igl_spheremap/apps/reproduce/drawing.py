"""Shaded surfaces in matplotlib, face by face from the back to the front: no display, no OpenGL."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: Where the light comes from, in the frame of the view.
_LIGHT = np.array([-0.35, 0.45, 0.82])
PLAIN, FOLDED = (0.80, 0.84, 0.88), (0.84, 0.24, 0.0)

#: What counts as up in files: z or y.
_UP = np.array([0.0, 1.0, 1.0])
#: A vertical axis that is closer to the ground than this is not taken for one.
_UPRIGHT = 0.3


def view_of(v: FloatArray) -> FloatArray:
    """Rotation that shows a body's long side: longest axis across, second one up, shortest one to the viewer.

    Parameters
    ----------
    v : (n, 3) float64 array
        Positions.

    Returns
    -------
    (3, 3) float64 array
        Positions times it are right, up, towards the viewer.
    """
    centred = v - v.mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    # The sign of an axis is that of its third moment, so that the same body is always shown from the same side.
    sign = ((centred @ axes.T) ** 3).sum(axis=0)
    # But up is up in the file: along z or y, whichever the format has.
    if abs(axes[1] @ _UP) > _UPRIGHT:
        sign[1] = axes[1] @ _UP
    axes *= np.where(sign < 0, -1.0, 1.0)[:, None]
    axes[2] *= np.sign(np.linalg.det(axes))
    return axes.T


def shading(v: FloatArray, f: IntArray, view: FloatArray, ambient: float = 0.35) -> FloatArray:
    """Brightness of each face.

    Parameters
    ----------
    v : (n, 3) float64 array
        Positions.
    f : (m, 3) int64 array
        Faces.
    view : (3, 3) float64 array
        Rotation from `view_of`.
    ambient : float
        Brightness of what the light grazes.

    Returns
    -------
    (m,) float64 array
        Between `ambient` and 1.
    """
    normals = _normals(v @ view, f)
    light = np.abs(normals @ _LIGHT) / np.linalg.norm(_LIGHT)
    return np.asarray(ambient + (1 - ambient) * light)


def draw(ax: Any, v: FloatArray, f: IntArray, colours: FloatArray, view: FloatArray, lines: bool = False) -> None:
    """Draw a closed surface.

    Parameters
    ----------
    ax : matplotlib axes
        Where to.
    v : (n, 3) float64 array
        Positions.
    f : (m, 3) int64 array
        Faces.
    colours : (m, 3) float64 array
        RGB of each face, shaded already.
    view : (3, 3) float64 array
        Rotation from `view_of`.
    lines : bool
        Whether edges are drawn.
    """
    from matplotlib.collections import PolyCollection

    y = v @ view
    order = np.argsort(y[f, 2].mean(axis=1), kind="stable")
    corners = y[f[order], :2]
    rgb = np.clip(colours[order], 0, 1)
    edges = "#5A636C" if lines else rgb
    ax.add_collection(PolyCollection(list(corners), facecolors=rgb, edgecolors=edges, linewidths=0.2, rasterized=True))
    middle, reach = (y.max(axis=0) + y.min(axis=0)) / 2, np.ptp(y[:, :2], axis=0).max() * 0.52
    ax.set(xlim=(middle[0] - reach, middle[0] + reach), ylim=(middle[1] - reach, middle[1] + reach), aspect="equal")
    ax.axis("off")


def painted(values: FloatArray, f: IntArray, reach: float) -> FloatArray:
    """Face colours of a function of the vertices.

    Parameters
    ----------
    values : (n,) float64 array
        The function.
    f : (m, 3) int64 array
        Faces.
    reach : float
        Size of value at which the colours end.

    Returns
    -------
    (m, 3) float64 array
        RGB.
    """
    from matplotlib import colormaps

    share = np.clip(values[f].mean(axis=1) / (2 * reach) + 0.5, 0, 1)
    return np.asarray(colormaps["RdBu_r"](share)[:, :3])


def _normals(v: FloatArray, f: IntArray) -> FloatArray:
    a, b, c = (v[f[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.divide(normals, size, out=np.zeros_like(normals), where=size > 0)
