"""Pictures of a surface and its maps on matplotlib axes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from ...draw.palette import FOLDED, SURFACE, diverging
from ...draw.raster import shading, view_of
from ...verify.certificate import orientation_signs
from .drawing import draw
from .surfaces import Surface

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def show_source(ax: Any, surface: Surface, x: FloatArray | None = None, *, title: str = "") -> None:
    """The source, and in vermilion the faces that a map folds."""
    _show(ax, surface, surface.v, _marked(surface, x), title)


def show_map(ax: Any, surface: Surface, x: FloatArray, *, title: str = "") -> None:
    """A map, lit like the source, whose shape it so shows, and in vermilion the faces that it folds."""
    _show(ax, surface, x, _marked(surface, x), title)


def show_function(ax: Any, surface: Surface, values: FloatArray, *, title: str = "") -> None:
    """A function of the vertices (n,) in colours on the source; white is its median, the title ends with the scale."""
    middle = float(np.median(values))
    values = values - middle
    ramp = diverging("", float(np.percentile(np.abs(values), 99)) or 1.0)
    title = f"{title}: {middle + ramp.low:.2g} (purple) to {middle + ramp.high:.2g} (green)"
    # Soft shades, for dark ones would be taken for strong colours.
    _show(ax, surface, surface.v, ramp.colours(values[surface.f].mean(axis=1)), title, ambient=0.75)


def _show(
    ax: Any, surface: Surface, where: FloatArray, colours: FloatArray, title: str, ambient: float = 0.35
) -> None:
    """Positions (n, 3) of the surface's vertices in face colours (m, 3), lit and seen as the source is."""
    view = view_of(surface.v)
    light = shading(surface.v, surface.f, view, ambient)
    draw(ax, where, surface.f, colours * light[:, None], view)
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
    draw(ax, plane, surface.f[near], _marked(surface, x)[near], np.eye(3), lines=True)
    ax.set(xlim=(-1, 1), ylim=(-1, 1))
    ax.set_title(f"{len(faces)} folded faces, {2 * reach:.1e} across", fontsize=8)


def folded_patches(surface: Surface, x: FloatArray) -> list[IntArray]:
    """Indices of folded faces, those that share a vertex together, the largest patch first."""
    folded = np.flatnonzero(orientation_signs(x, surface.f) <= 0)
    n, k = len(surface.v), len(folded)
    corners = surface.f[folded].ravel()
    links = coo_matrix((np.ones(3 * k, dtype=np.int8), (np.repeat(np.arange(k), 3), corners)), shape=(k, n))
    _, label = connected_components(links @ links.T, directed=False)
    patches = [folded[label == one] for one in range(label.max(initial=-1) + 1)]
    return sorted(patches, key=len, reverse=True)


def _marked(surface: Surface, x: FloatArray | None) -> FloatArray:
    """Face colours (m, 3) that mark folded faces."""
    colours = np.tile(SURFACE, (len(surface.f), 1))
    if x is not None:
        colours[orientation_signs(x, surface.f) <= 0] = FOLDED
    return colours
