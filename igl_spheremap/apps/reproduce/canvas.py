"""Pictures of a surface and its maps on matplotlib axes: no display, no OpenGL."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...draw.folds import Marks
from ...draw.palette import FOLDED, GUIDE, LINES, SURFACE, Ramp
from ...draw.plot import colour_bar, frame, new_figure, pose, raster, shading
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray
from ...verify.signs import folded_faces
from .surfaces import PaperSurface

#: Width of every figure in inches, that of a page: texts are read in the size that they have here.
PAGE = 7.2
TEXT = 7  # points
_NONE = np.empty(0, dtype=np.int64)
_ASPECT = 1.25  # width over height of a picture
_SIDE = 1.04  # side of the view, in units of the body's own


def page_figure(rows: int, columns: int, title: str, height: float) -> tuple[Any, Any]:
    """A figure as wide as a page, and its axes (rows, columns), each of this height in inches."""
    figure, axes = new_figure(rows, columns, "", (PAGE / columns, height))
    figure.suptitle(title, fontsize=TEXT + 2)
    return figure, axes


def caption(ax: Any, text: str) -> None:
    """A title above a panel."""
    ax.set_title(text, fontsize=TEXT)


def show_source(
    ax: Any, surface: PaperSurface, x: FloatArray | None = None, *, title: str = ""
) -> None:
    """The source, and in vermilion the faces that a map folds."""
    folded = _NONE
    if x is not None:
        folded = np.flatnonzero(folded_faces(x, surface.f))
    show_surface(ax, surface, surface.v, title, folded)


def show_image(
    ax: Any, surface: PaperSurface, x: FloatArray, radius: float = 1.0, *, title: str = ""
) -> None:
    """A map, or other positions of the vertices, in vermilion the faces that face inwards, and a sphere's outline."""
    from matplotlib.patches import Circle

    show_surface(ax, surface, x, title, np.flatnonzero(folded_faces(x, surface.f)), sphere=True)
    ax.add_patch(Circle((0, 0), radius, fill=False, color=GUIDE, linewidth=0.5))
    height = _SIDE * max(radius, float(np.linalg.norm(x, axis=1).max()))
    ax.set(xlim=(-_ASPECT * height, _ASPECT * height), ylim=(-height, height))
    if np.ptp(x, axis=0).max() < 0.02:  # it has collapsed
        ax.plot(
            *(x.mean(axis=0) @ pose(surface.v, surface.up).T)[:2],
            "o",
            color=FOLDED,
            markersize=3,
            clip_on=False,
        )
        caption(ax, f"{title},\nat one point")


def show_function(
    ax: Any, surface: PaperSurface, values: FloatArray, ramp: Ramp, folded: IntArray = _NONE, *, title: str = "",
    bar: bool = True,
) -> None:  # fmt: skip
    """A function of the vertices (n,) in colours on the source, with their bar, and marks of small folded faces."""
    colours = ramp.colours(values[surface.f].mean(axis=1))
    # Soft shades: dark ones would be taken for strong colours.
    show_surface(ax, surface, surface.v, title, folded, colours, ambient=0.75)
    if bar:
        colour_bar(ax, ramp)


def show_angles(ax: Any, results: dict[str, SphereMap], largest: int = 180) -> None:
    """Angle differences of maps of one surface, counted by degree on a logarithmic axis."""
    for (name, result), colour in zip(results.items(), LINES, strict=False):
        differences = result.angle_differences().ravel()
        counts, edges = np.histogram(differences, np.arange(-largest - 0.5, largest + 1))
        label = f"{name}: mean {np.abs(differences).mean():.2f}°"
        ax.stairs(counts, edges, color=colour, label=label, linewidth=1)
    ax.set(yscale="log", xticks=(-largest, 0, largest))
    ax.set_xlabel("angle difference, degrees", fontsize=TEXT)
    ax.set_ylabel("angles per degree", fontsize=TEXT)
    ax.tick_params(labelsize=TEXT)
    ax.legend(
        fontsize=TEXT - 1,
        frameon=False,
        loc="lower center",
        bbox_to_anchor=(0.5, 1),
        borderpad=0,
        handlelength=1,
    )


def show_surface(
    ax: Any, surface: PaperSurface, where: FloatArray, title: str, folded: IntArray = _NONE,
    colours: FloatArray | None = None, ambient: float = 0.35, *, sphere: bool = False,
) -> None:  # fmt: skip
    """Positions (n, 3) of the surface's vertices in face colours (m, 3), lit and seen as the source is.

    Folded faces that are too small to be seen have a dot, those that lie behind have a ring. The axes have the
    coordinates of the view.
    """
    view = pose(surface.v, surface.up).T
    y = where @ view
    if colours is None:
        colours = np.tile(SURFACE, (len(surface.f), 1))
    colours = colours * shading(surface.v, surface.f, view, ambient)[:, None]
    (x0, y0, _), radius = frame(y)
    # about the pixels of a row's pictures in a PNG, so that no thin limb is lost
    pixels = 1600 // ax.get_subplotspec().get_gridspec().ncols
    picture = raster(y, surface.f, colours, pixels, folded)
    ax.imshow(
        picture,
        extent=(x0 - radius, x0 + radius, y0 - radius, y0 + radius),
        interpolation="nearest",
    )
    unseen, front = Marks.of(y, surface.f, folded, sphere).unseen(
        np.array([0.0, 0, 1]), pixels / (2 * radius)
    )
    for places, inside in ((unseen[front], FOLDED), (unseen[~front], "none")):
        ax.scatter(
            *places[:, :2].T,
            s=9,
            facecolors=inside,
            edgecolors=FOLDED,
            linewidths=0.6,
            clip_on=False,
            zorder=3,
        )
    width, height = _SIDE * np.ptp(y, axis=0)[:2] / 2
    height = max(height, width / _ASPECT)  # so that panels of a row are equally high
    ax.set(xlim=(x0 - _ASPECT * height, x0 + _ASPECT * height), ylim=(y0 - height, y0 + height))
    ax.axis("off")
    caption(ax, title)
