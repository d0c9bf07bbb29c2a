"""Pictures of a surface and its maps on matplotlib axes: no display, no OpenGL."""

from __future__ import annotations

from itertools import islice
from typing import Any

import numpy as np

from ...draw.folds import MANY, Clusters
from ...draw.palette import FOLDED, GUIDE, INK, LINES, SURFACE, diverging
from ...draw.plot import frame, new_figure, pose, raster, shading
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.measure import face_areas
from ...sphere.rows import unit_rows
from ...verify.signs import folded_faces
from .surfaces import PaperSurface

#: Width of every figure in inches, that of a page: texts are read in the size that they have here.
PAGE = 7.2
TEXT = 7  # points
_NONE = np.empty(0, dtype=np.int64)
_PIXELS = 1600  # of the pictures in a row together: about as many as they have in a PNG, so that no thin limb is lost
_DOT = 0.02  # a map of less extent has collapsed
_LARGEST = 180  # degrees: no angle difference is larger
_ASPECT = 1.25  # width over height of a picture
_SIDE = 1.04  # side of what is shown, in units of the body's own
#: Boxes are drawn around as many patches of folded faces, and only around those that take less than half the picture.
_BOXES = 6
_SHARE = 0.5
_PAD = 0.06  # between a box and its patch, in units of half the picture
_EVEN = 0.01  # share by which the ends of a scale may differ that is called the same on both sides
#: Percentiles of the values that have the colours of the ends.
_ENDS = (1, 99)


def page_figure(rows: int, columns: int, title: str, height: float) -> tuple[Any, Any]:
    """A figure as wide as a page, and its axes (rows, columns), each of this height in inches."""
    figure, axes = new_figure(rows, columns, "", (PAGE / columns, height))
    figure.suptitle(title, fontsize=TEXT + 2)
    return figure, axes


def caption(ax: Any, text: str) -> None:
    """A title above a panel."""
    ax.set_title(text, fontsize=TEXT)


def show_source(ax: Any, surface: PaperSurface, x: FloatArray | None = None, *, title: str = "") -> None:
    """The source, and in vermilion the faces that a map folds; boxes around small patches of them."""
    folded = _NONE if x is None else np.flatnonzero(folded_faces(x, surface.f))
    show_surface(ax, surface, surface.v, title, folded)
    _box(ax, surface, surface.v, folded)


def show_map(ax: Any, surface: PaperSurface, x: FloatArray, *, title: str = "") -> None:
    """A map on the unit sphere, with the brightness of the source's faces; in vermilion what it folds, with boxes.

    A map that has collapsed is a dot.
    """
    folded = np.flatnonzero(folded_faces(x, surface.f))  # of the map as it is: normalised it may have others
    x = unit_rows(x)
    show_surface(ax, surface, x, title, folded)
    _sphere(ax, x, 1.0, color=GUIDE, linewidth=0.5)
    if np.ptp(x, axis=0).max() < _DOT:
        middle = x.mean(axis=0) @ pose(surface.v, surface.up).T
        ax.plot(*middle[:2], "o", color=FOLDED, markersize=3, clip_on=False)
        caption(ax, f"{title},\nat one point")
    else:
        _box(ax, surface, x, folded, behind=":")


def show_shape(ax: Any, surface: PaperSurface, x: FloatArray, radius: float, *, title: str = "") -> None:
    """Other positions of the vertices, in vermilion the faces that face inwards, and the sphere of a radius, dotted."""
    show_surface(ax, surface, x, title, np.flatnonzero(folded_faces(x, surface.f)))
    _sphere(ax, x, radius, color=INK, linestyle=":")


def function_scale(*values: FloatArray) -> Any:
    """A scale from purple over white at 0 to green for functions that are compared; its two halves fit the values."""
    from matplotlib.colors import TwoSlopeNorm

    low, high = np.percentile(np.concatenate(values), _ENDS)
    least = 1e-3 * max(abs(low), abs(high), 1e-9)
    return TwoSlopeNorm(0.0, min(low, -least), max(high, least))


def show_function(
    ax: Any, surface: PaperSurface, values: FloatArray, scale: Any = None, *, title: str = "", box: IntArray = _NONE,
    bar: bool = True,
) -> None:  # fmt: skip
    """A function of the vertices (n,) in colours on the source, with their bar; boxes around patches of faces."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LinearSegmentedColormap

    scale = scale or function_scale(values)
    ramp = LinearSegmentedColormap.from_list("", diverging("", 1.0).stops)
    colours = ramp(scale(values[surface.f].mean(axis=1)))[:, :3]
    # Soft shades, for dark ones would be taken for strong colours.
    show_surface(ax, surface, surface.v, title, colours=colours, ambient=0.75)
    _box(ax, surface, surface.v, box)
    if bar:
        drawn = ax.figure.colorbar(ScalarMappable(scale, ramp), ax=ax, orientation="horizontal", shrink=0.7, aspect=25,
                                   pad=0.02)
        drawn.set_ticks([scale.vmin, 0.0, scale.vmax], labels=[f"{scale.vmin:.2g}", "0", f"{scale.vmax:.2g}"])
        if abs(scale.vmin + scale.vmax) > _EVEN * scale.vmax:
            drawn.set_label("one scale below 0, another above", fontsize=TEXT)
        drawn.ax.tick_params(labelsize=TEXT)
        drawn.outline.set_visible(False)


def show_angles(ax: Any, results: dict[str, SphereMap]) -> None:
    """Angle differences of maps of one surface, counted by degree on a logarithmic axis."""
    for (name, result), colour in zip(results.items(), LINES, strict=False):
        differences = result.angle_differences().ravel()
        counts, edges = np.histogram(differences, np.arange(-_LARGEST - 0.5, _LARGEST + 1))
        label = f"{name}: mean {np.abs(differences).mean():.2f}°"
        ax.stairs(counts, edges, color=colour, label=label, linewidth=1)
    ax.set(yscale="log", xticks=(-_LARGEST, 0, _LARGEST))
    ax.set_xlabel("angle difference, degrees", fontsize=TEXT)
    ax.set_ylabel("angles per degree", fontsize=TEXT)
    ax.tick_params(labelsize=TEXT)
    ax.legend(fontsize=TEXT - 1, frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1), borderpad=0,
              handlelength=1)


def show_surface(
    ax: Any, surface: PaperSurface, where: FloatArray, title: str, folded: IntArray = _NONE,
    colours: FloatArray | None = None, ambient: float = 0.35,
) -> None:  # fmt: skip
    """Positions (n, 3) of the surface's vertices in face colours (m, 3), lit and seen as the source is.

    Its axes have the coordinates of the view.
    """
    view = pose(surface.v, surface.up).T
    y = where @ view
    colours = np.tile(SURFACE, (len(surface.f), 1)) if colours is None else colours
    colours = colours * shading(surface.v, surface.f, view, ambient)[:, None]
    (x0, y0, _), radius = frame(y)
    pixels = _PIXELS // ax.get_subplotspec().get_gridspec().ncols
    picture = raster(y, surface.f, colours, pixels, folded)
    ax.imshow(picture, extent=(x0 - radius, x0 + radius, y0 - radius, y0 + radius), interpolation="nearest")
    width, height = _SIDE * np.ptp(y, axis=0)[:2] / 2
    height = max(height, width / _ASPECT)  # so that panels of a row are equally high
    ax.set(xlim=(x0 - _ASPECT * height, x0 + _ASPECT * height), ylim=(y0 - height, y0 + height))
    ax.axis("off")
    caption(ax, title)


def _sphere(ax: Any, x: FloatArray, radius: float, **style: Any) -> None:
    """The outline of a sphere about the origin, and axes that hold it and the positions."""
    from matplotlib.patches import Circle

    ax.add_patch(Circle((0, 0), radius, fill=False, **style))
    height = _SIDE * max(radius, float(np.linalg.norm(x, axis=1).max()))
    ax.set(xlim=(-_ASPECT * height, _ASPECT * height), ylim=(-height, height))


def _box(ax: Any, surface: PaperSurface, where: FloatArray, faces: IntArray, behind: str = "-") -> None:
    """Boxes around patches of faces, unless these are many; of lines of another kind behind a sphere's middle."""
    from matplotlib.patches import FancyBboxPatch

    sizes = face_areas(where, surface.f)
    if sizes[faces].sum() >= MANY * sizes.sum():
        return
    y = where @ pose(surface.v, surface.up).T
    middle, radius = frame(y)
    for patch in islice(Clusters.of(surface.f, faces), _BOXES):
        corners = y[surface.f[patch]].reshape(-1, 3)
        low, size = corners.min(axis=0), np.ptp(corners, axis=0)
        if size[:2].max() < 2 * _SHARE * radius:
            line = "-" if corners[:, 2].mean() >= middle[2] else behind
            ax.add_patch(FancyBboxPatch((low[0], low[1]), size[0], size[1], boxstyle=f"round,pad={_PAD * radius}",
                                        fill=False, edgecolor=FOLDED, linestyle=line, clip_on=False))


def show_fold(ax: Any, surface: PaperSurface, x: FloatArray, patches: Clusters) -> None:
    """A map around its largest patch of folded faces, so close that folds of a millionth of the sphere are visible.

    It is see-through; without folded faces some other place is shown.
    """
    from matplotlib.collections import PolyCollection

    faces = patches[0] if len(patches) else np.array([0])
    corners = x[surface.f[faces]].reshape(-1, 3)
    middle = corners.mean(axis=0)
    middle /= np.linalg.norm(middle)
    reach = min(1.5 * max(float(np.linalg.norm(corners - middle, axis=1).max()), 1e-12), 1.0)
    across = np.linalg.svd(middle[None])[2][1:]
    near = np.flatnonzero((np.linalg.norm(x[surface.f] - middle, axis=2) < 2 * reach).any(axis=1))
    plane = (x - middle) @ across.T / reach
    colours = np.where(folded_faces(x, surface.f)[near, None], FOLDED, SURFACE)
    ax.add_collection(PolyCollection(list(plane[surface.f[near]]), facecolors=colours, edgecolors=INK, linewidths=0.2,
                                     alpha=0.5, rasterized=True))
    ax.set(xlim=(-1, 1), ylim=(-1, 1), aspect="equal")
    ax.axis("off")
    what = f"the largest patch, {len(faces):,} faces" if len(patches) else "no folded face"
    caption(ax, f"{what}, see-through:\n{2 * reach:.2g} radii across")
