"""Shaded surfaces in matplotlib, face by face from the back to the front: no display, no OpenGL."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...draw.palette import INK
from ...mesh.arrays import FloatArray, IntArray


def draw(
    ax: Any,
    v: FloatArray,
    f: IntArray,
    colours: FloatArray,
    view: FloatArray,
    lines: bool = False,
    front: IntArray | None = None,
) -> None:
    """Draw a closed surface in face colours (m, 3) that are shaded already, with its edges or without.

    Faces whose indices are in `front` hide all others if they lie in the nearer half.
    """
    from matplotlib.collections import PolyCollection

    y = v @ view
    depth = y[f, 2].mean(axis=1)
    if front is not None:
        depth[front[depth[front] > depth.mean()]] += np.ptp(depth)
    order = np.argsort(depth, kind="stable")
    corners = y[f[order], :2]
    rgb = np.clip(colours[order], 0, 1)
    edges = INK if lines else rgb
    ax.add_collection(PolyCollection(list(corners), facecolors=rgb, edgecolors=edges, linewidths=0.2, rasterized=True))
    middle, reach = (y.max(axis=0) + y.min(axis=0)) / 2, np.ptp(y[:, :2], axis=0).max() * 0.52
    ax.set(xlim=(middle[0] - reach, middle[0] + reach), ylim=(middle[1] - reach, middle[1] + reach), aspect="equal")
    ax.axis("off")
