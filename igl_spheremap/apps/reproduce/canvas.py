"""Empty matplotlib figures, and pictures of maps on them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from ...errors import import_optional
from ...verify.certificate import orientation_signs
from .drawing import FOLDED, PLAIN, draw, painted, shading, view_of
from .surfaces import Surface

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def new_figure(rows: int, columns: int, title: str, size: float = 3.2) -> tuple[Any, Any]:
    """A figure with a grid of axes.

    Parameters
    ----------
    rows, columns : int
        Of the grid.
    title : str
        Over all.
    size : float
        Width and height of a panel in inches.

    Returns
    -------
    matplotlib.figure.Figure
        Known to no window system.
    (rows, columns) array of axes

    Raises
    ------
    FileError
        If matplotlib is not installed.
    """
    figure_module = import_optional("matplotlib.figure", "a figure", "plot")
    figure = figure_module.Figure(figsize=(size * columns, size * rows + 0.4), layout="constrained", dpi=150)
    figure.suptitle(title, fontsize=10)
    return figure, figure.subplots(rows, columns, squeeze=False)


def show_source(ax: Any, surface: Surface, x: FloatArray | None = None) -> None:
    """The source, and in vermilion what a map folds.

    Parameters
    ----------
    ax : matplotlib axes
        Where to.
    surface : Surface
        The source.
    x : (n, 3) float64 array, optional
        The map.
    """
    view = view_of(surface.v)
    draw(ax, surface.v, surface.f, _marked(surface, x) * shading(surface.v, surface.f, view)[:, None], view)


def show_sphere(ax: Any, surface: Surface, x: FloatArray) -> None:
    """The map, lit as the source is, so that its shape can be made out; and in vermilion what it folds.

    Parameters
    ----------
    ax : matplotlib axes
        Where to.
    surface : Surface
        The source.
    x : (n, 3) float64 array
        The map.
    """
    view = view_of(surface.v)
    draw(ax, x, surface.f, _marked(surface, x) * shading(surface.v, surface.f, view)[:, None], view)


def show_function(ax: Any, surface: Surface, values: FloatArray, x: FloatArray | None = None) -> None:
    """A function of the vertices in colours, on the source or on a map.

    Parameters
    ----------
    ax : matplotlib axes
        Where to.
    surface : Surface
        The source.
    values : (n,) float64 array
        The function; white is its median.
    x : (n, 3) float64 array, optional
        The map to draw it on.
    """
    view, where = view_of(surface.v), surface.v if x is None else x
    values = values - np.median(values)
    reach = float(np.percentile(np.abs(values), 99)) or 1.0
    # Soft shades, for dark ones would be taken for strong colours.
    colours = painted(values, surface.f, reach) * shading(where, surface.f, view, ambient=0.75)[:, None]
    draw(ax, where, surface.f, colours, view)


def show_fold(ax: Any, surface: Surface, x: FloatArray, faces: IntArray) -> None:
    """The map around some of its faces, so close that folds show which are a millionth of the sphere.

    Parameters
    ----------
    ax : matplotlib axes
        Where to.
    surface : Surface
        The source.
    x : (n, 3) float64 array
        The map.
    faces : (k,) int64 array
        Faces to be in the middle.
    """
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
    """Folded faces, those that share a vertex together, the largest patch first.

    Parameters
    ----------
    surface : Surface
        The source.
    x : (n, 3) float64 array
        The map.

    Returns
    -------
    list of (k,) int64 array
        Face indices.
    """
    folded = np.flatnonzero(orientation_signs(x, surface.f) <= 0)
    n, k = len(surface.v), len(folded)
    corners = surface.f[folded].ravel()
    links = coo_matrix((np.ones(3 * k, dtype=np.int8), (np.repeat(np.arange(k), 3), corners)), shape=(k, n))
    _, label = connected_components(links @ links.T, directed=False)
    patches = [folded[label == one] for one in range(label.max(initial=-1) + 1)]
    return sorted(patches, key=len, reverse=True)


def _marked(surface: Surface, x: FloatArray | None) -> FloatArray:
    colours = np.tile(PLAIN, (len(surface.f), 1))
    if x is not None:
        colours[orientation_signs(x, surface.f) <= 0] = FOLDED
    return colours
