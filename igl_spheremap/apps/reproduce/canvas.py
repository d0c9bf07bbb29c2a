"""Pictures of a surface and its maps on matplotlib axes: no display, no OpenGL."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ...draw.folds import Clusters
from ...draw.palette import FOLDED, INK, SURFACE, diverging
from ...draw.plot import SMALL, colour_bar, pose, raster, shading
from ...mesh.arrays import FloatArray, IntArray
from ...sphere.rows import unit_rows
from ...verify.signs import folded_faces
from ..viewer.body import follow
from .runs import PaperSurface

_NONE = np.empty(0, dtype=np.int64)
_PIXELS = 500  # along a side of a picture


def show_source(ax: Any, surface: PaperSurface, x: FloatArray | None = None, *, title: str = "") -> None:
    """The source, and in vermilion the faces that a map folds."""
    _show(ax, surface, surface.v, title, _NONE if x is None else _folded(surface, x))


def show_map(ax: Any, surface: PaperSurface, x: FloatArray, *, title: str = "") -> None:
    """A map with the brightness of the source's faces; where it folds, magnified at the largest cluster of foldings."""
    folded = _folded(surface, x)
    if not len(folded):
        _show(ax, surface, x, title)
        return
    lens = follow(unit_rows(x), surface.f, folded)
    _show(ax, surface, lens(unit_rows(x)), f"{title}, magnified {lens.power:,.0f}x", folded, np.eye(3))


def show_shape(ax: Any, surface: PaperSurface, x: FloatArray, *, title: str = "") -> None:
    """Other positions of the vertices, in vermilion the faces that face inwards."""
    _show(ax, surface, x, title, _folded(surface, x))


def show_function(ax: Any, surface: PaperSurface, values: FloatArray, *, title: str = "") -> None:
    """A function of the vertices (n,) in colours on the source, with a colour bar; white is its median."""
    middle = float(np.median(values))
    values = values - middle
    ramp = diverging("", float(np.percentile(np.abs(values), 99)) or 1.0)
    ends = [f"{end:.2g}" for end in (middle + ramp.low, middle + ramp.high)]
    # Soft shades, for dark ones would be taken for strong colours.
    _show(ax, surface, surface.v, title, colours=ramp.colours(values[surface.f].mean(axis=1)), ambient=0.75)
    colour_bar(ax, replace(ramp, names=(ends[0], ends[1])))


def _show(
    ax: Any,
    surface: PaperSurface,
    where: FloatArray,
    title: str,
    folded: IntArray = _NONE,
    view: FloatArray | None = None,
    colours: FloatArray | None = None,
    ambient: float = 0.35,
) -> None:
    """Positions (n, 3) of the surface's vertices in face colours (m, 3), lit and by default seen as the source is."""
    own = pose(surface.v).T
    colours = np.tile(SURFACE, (len(surface.f), 1)) if colours is None else colours
    shaded = colours * shading(surface.v, surface.f, own, ambient)[:, None]
    ax.imshow(raster(where @ (own if view is None else view), surface.f, shaded, _PIXELS, folded))
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
    folded = folded_faces(x, surface.f)[near]
    order = np.argsort(folded, kind="stable")  # folded faces in front
    colours = np.where(folded[order, None], FOLDED, SURFACE)
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

