"""Pictures of a surface and its maps on matplotlib axes: no display, no OpenGL."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...draw.folds import Clusters
from ...draw.palette import FOLDED, INK, SURFACE, diverging
from ...draw.plot import SMALL, pose, raster, shading
from ...mesh.arrays import FloatArray, IntArray
from ...sphere.rows import unit_rows
from ...verify.signs import folded_faces
from ..viewer.body import follow
from .runs import PaperSurface

_NONE = np.empty(0, dtype=np.int64)
_PIXELS = 500  # along a side of a picture


def show_source(ax: Any, surface: PaperSurface, x: FloatArray | None = None, *, title: str = "") -> None:
    """The source, and in vermilion the faces that a map folds."""
    folded = _NONE if x is None else _folded(surface, x)
    _show(ax, surface, surface.v, _marked(surface, folded), title)


def show_map(ax: Any, surface: PaperSurface, x: FloatArray, *, title: str = "") -> None:
    """A map with the brightness of the source's faces; where it folds, magnified at the largest cluster of foldings."""
    folded = _folded(surface, x)
    colours = _marked(surface, folded)
    if not len(folded):
        _show(ax, surface, x, colours, title)
        return
    lens = follow(unit_rows(x), surface.f, folded)
    _show(ax, surface, lens(unit_rows(x)), colours, f"{title}, magnified {lens.power:,.0f}x", np.eye(3), folded)


def show_shape(ax: Any, surface: PaperSurface, x: FloatArray, *, title: str = "") -> None:
    """Other positions of the vertices, in vermilion the faces that face inwards."""
    _show(ax, surface, x, _marked(surface, _folded(surface, x)), title)


def show_function(ax: Any, surface: PaperSurface, values: FloatArray, *, title: str = "") -> None:
    """A function of the vertices (n,) in colours on the source, with a colour bar; white is its median."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LinearSegmentedColormap, Normalize

    middle = float(np.median(values))
    values = values - middle
    ramp = diverging("", float(np.percentile(np.abs(values), 99)) or 1.0)
    # Soft shades, for dark ones would be taken for strong colours.
    _show(ax, surface, surface.v, ramp.colours(values[surface.f].mean(axis=1)), title, ambient=0.75)
    ends = middle + ramp.low, middle + ramp.high
    scale = ScalarMappable(Normalize(*ends), LinearSegmentedColormap.from_list("", ramp.stops))
    bar = ax.figure.colorbar(scale, ax=ax, orientation="horizontal", shrink=0.6, aspect=30, pad=0.02)
    ticks = [ends[0], middle, ends[1]]
    bar.set_ticks(ticks, labels=[f"{tick:.2g}" if abs(tick) > 1e-9 * np.ptp(ends) else "0" for tick in ticks])
    bar.ax.tick_params(labelsize=8)
    bar.outline.set_visible(False)


def _show(
    ax: Any,
    surface: PaperSurface,
    where: FloatArray,
    colours: FloatArray,
    title: str,
    view: FloatArray | None = None,
    front: IntArray = _NONE,
    ambient: float = 0.35,
) -> None:
    """Positions (n, 3) of the surface's vertices in face colours (m, 3), lit and by default seen as the source is.

    Faces whose indices are in `front` hide all others if they lie in the nearer half.
    """
    own = pose(surface.v).T
    colours = colours * shading(surface.v, surface.f, own, ambient)[:, None]
    y, f = where @ (own if view is None else view), surface.f
    depth = y[f, 2].mean(axis=1)
    front = front[depth[front] > depth.mean()]
    raised = y[f[front]].reshape(-1, 3) + np.array([0, 0, np.ptp(depth)])
    f = np.concatenate((f, len(y) + np.arange(len(raised)).reshape(-1, 3)))
    ax.imshow(raster(np.concatenate((y, raised)), f, np.concatenate((colours, colours[front])), _PIXELS))
    ax.axis("off")
    ax.set_title(title, fontsize=SMALL)


def show_fold(ax: Any, surface: PaperSurface, x: FloatArray, faces: IntArray) -> None:
    """A map around some of its faces, so close that folds of a millionth of the sphere are visible."""
    from matplotlib.collections import PolyCollection

    corners = x[surface.f[faces]].reshape(-1, 3)
    middle = corners.mean(axis=0)
    middle /= np.linalg.norm(middle)
    reach = min(1.5 * max(float(np.linalg.norm(corners - middle, axis=1).max()), 1e-12), 1.0)
    across = np.linalg.svd(middle[None])[2][1:]
    near = np.linalg.norm(x[surface.f].mean(axis=1) - middle, axis=1) < 3 * reach
    plane = (x - middle) @ across.T / reach
    order = np.argsort(folded_faces(x, surface.f)[near], kind="stable")  # folded faces in front
    colours = _marked(surface, _folded(surface, x))[near][order]
    corners = plane[surface.f[near][order]]
    patch = PolyCollection(list(corners), facecolors=colours, edgecolors=INK, linewidths=0.2, rasterized=True)
    ax.add_collection(patch)
    ax.set(xlim=(-1, 1), ylim=(-1, 1), aspect="equal")
    ax.axis("off")
    ax.set_title(f"{len(faces)} folded faces, {2 * reach:.1e} across", fontsize=SMALL)


def folded_patches(surface: PaperSurface, x: FloatArray) -> list[IntArray]:
    """Indices of folded faces, those that share a vertex together, the largest patch first."""
    return list(Clusters.of(surface.f, _folded(surface, x)))


def _folded(surface: PaperSurface, x: FloatArray) -> IntArray:
    return np.flatnonzero(folded_faces(x, surface.f))


def _marked(surface: PaperSurface, folded: IntArray) -> FloatArray:
    """Face colours (m, 3) that mark folded faces."""
    colours = np.tile(SURFACE, (len(surface.f), 1))
    colours[folded] = FOLDED
    return colours
