"""Pictures of a surface and its maps on matplotlib axes: no display, no OpenGL."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...draw.palette import FOLDED, INK, SURFACE, diverging
from ...draw.plot import shading, view_of
from ...mesh.arrays import FloatArray, IntArray
from ...sphere.rows import unit_rows
from ...verify.signs import folded_faces
from ..viewer.body import clusters, follow
from .runs import Surface

_NONE = np.empty(0, dtype=np.int64)


def show_source(ax: Any, surface: Surface, x: FloatArray | None = None, *, title: str = "") -> None:
    """The source, and in vermilion the faces that a map folds."""
    folded = _NONE if x is None else _folded(surface, x)
    _show(ax, surface, surface.v, _marked(surface, folded), title)


def show_map(ax: Any, surface: Surface, x: FloatArray, *, title: str = "") -> None:
    """A map with the brightness of the source's faces; where it folds, through a lens on the largest cluster."""
    folded = _folded(surface, x)
    colours = _marked(surface, folded)
    if not len(folded):
        _show(ax, surface, x, colours, title)
        return
    lens = follow(unit_rows(x), surface.f, folded)
    _show(ax, surface, lens(unit_rows(x)), colours, f"{title}, magnified {lens.power:,.0f}x", np.eye(3), folded)


def show_shape(ax: Any, surface: Surface, x: FloatArray, *, title: str = "") -> None:
    """Other positions of the vertices, in vermilion the faces that face inwards."""
    _show(ax, surface, x, _marked(surface, _folded(surface, x)), title)


def show_function(ax: Any, surface: Surface, values: FloatArray, *, title: str = "") -> None:
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
    bar.set_ticks(ticks, labels=[f"{tick:.2g}" for tick in ticks])
    bar.ax.tick_params(labelsize=8)
    bar.outline.set_visible(False)


def _show(
    ax: Any,
    surface: Surface,
    where: FloatArray,
    colours: FloatArray,
    title: str,
    view: FloatArray | None = None,
    front: IntArray = _NONE,
    ambient: float = 0.35,
) -> None:
    """Positions (n, 3) of the surface's vertices in face colours (m, 3), lit and by default seen as the source is."""
    own = view_of(surface.v)
    light = shading(surface.v, surface.f, own, ambient)
    _draw(ax, where, surface.f, colours * light[:, None], own if view is None else view, front=front)
    ax.set_title(title, fontsize=8)


def show_fold(ax: Any, surface: Surface, x: FloatArray, faces: IntArray) -> None:
    """A map around some of its faces, so close that folds of a millionth of the sphere are visible."""
    corners = x[surface.f[faces]].reshape(-1, 3)
    middle = corners.mean(axis=0)
    middle /= np.linalg.norm(middle)
    reach = min(1.5 * max(float(np.linalg.norm(corners - middle, axis=1).max()), 1e-12), 1.0)
    across = np.linalg.svd(middle[None])[2][1:]
    near = np.linalg.norm(x[surface.f].mean(axis=1) - middle, axis=1) < 3 * reach
    plane = np.column_stack(((x - middle) @ across.T, np.zeros(len(x)))) / reach
    _draw(ax, plane, surface.f[near], _marked(surface, _folded(surface, x))[near], np.eye(3), lines=True)
    ax.set(xlim=(-1, 1), ylim=(-1, 1))
    ax.set_title(f"{len(faces)} folded faces, {2 * reach:.1e} across", fontsize=8)


def folded_patches(surface: Surface, x: FloatArray) -> list[IntArray]:
    """Indices of folded faces, those that share a vertex together, the largest patch first."""
    folded = _folded(surface, x)
    return [folded[patch] for patch in clusters(surface.f[folded])]


def _folded(surface: Surface, x: FloatArray) -> IntArray:
    return np.flatnonzero(folded_faces(x, surface.f))


def _marked(surface: Surface, folded: IntArray) -> FloatArray:
    """Face colours (m, 3) that mark folded faces."""
    colours = np.tile(SURFACE, (len(surface.f), 1))
    colours[folded] = FOLDED
    return colours


def _draw(
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
