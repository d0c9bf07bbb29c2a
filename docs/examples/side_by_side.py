"""Surfaces side by side in a figure of matplotlib, without OpenGL: common code of this folder's examples."""

import numpy as np

from igl_spheremap.draw.palette import SURFACE, sequential
from igl_spheremap.draw.plot import SMALL, colour_bar, new_figure, pose, raster, shading

PIXELS = 420  # along a side of a picture of a surface
AMBIENT = 0.5  # brightness where light grazes a surface


def draw_surfaces(*views, up="auto"):
    """A figure of surfaces side by side, without OpenGL; all in the first one's pose.

    A view is a caption, positions (n, 3), faces (m, 3), then values at vertices or faces, face colours (m, 3), or None;
    and, if it has them, indices of folded faces. Values have a colour bar below the first view that shows them.
    """
    shape = (2, 2) if len(views) == 4 else (1, len(views))  # four in a row would be small
    figure, axes = new_figure(*shape, "", (2.6, 2.9))
    turn, shown = pose(views[0][1], up), None
    for ax, (caption, x, f, values, *folded) in zip(axes.ravel(), views, strict=True):
        colours = np.tile(SURFACE, (len(f), 1))
        if values is not None and values.ndim == 2:
            colours = values
        elif values is not None:
            at_faces = values[f].mean(axis=1) if len(values) == len(x) else values
            ramp = sequential("", *np.percentile(at_faces, [1, 99]).tolist())
            colours = ramp.colours(at_faces)
            if shown is None or not np.array_equal(values, shown):
                colour_bar(ax, ramp)
            shown = values
        shaded = colours * shading(x, f, turn.T, AMBIENT)[:, None]
        ax.imshow(raster(x @ turn.T, f, shaded, PIXELS, *folded))
        ax.axis("off")
        ax.set_title(caption, fontsize=SMALL)
    return figure
