"""How the viewer looks: the palette, and what only a window has."""

from __future__ import annotations

import numpy as np

from ...draw.palette import FOLDED, INK, LINES, SURFACE, Colour, Ramp, diverging, round_up, sequential
from ...mesh.arrays import FloatArray

__all__ = [
    "BACKGROUND",
    "CHECKS",
    "EDGES",
    "FOLDED",
    "FOLDED_EDGES",
    "INK",
    "LINES",
    "SURFACE",
    "Colour",
    "Ramp",
    "diverging",
    "linear",
    "matcaps",
    "round_up",
    "sequential",
]


BACKGROUND: Colour = (1.0, 1.0, 1.0)
EDGES: Colour = (0.45, 0.50, 0.55)
#: Folded faces are the only red of a picture, and so are the edges between them.
FOLDED_EDGES: Colour = (0.66, 0.12, 0.0)
CHECKS: tuple[Colour, Colour] = ((0.13, 0.32, 0.52), (0.95, 0.93, 0.86))


def matcaps() -> list[FloatArray]:
    """Images (256, 256, 3) of a lit ball in red, green, blue and black, which make a blendable material of polyscope.

    The light comes from the viewer's upper left. A colour c is seen as c times the shade: polyscope's own
    materials would wash it out, and then no legend fits.
    """
    y, x = np.mgrid[1 - 1 / 256 : -1 : -1 / 128, -1 + 1 / 256 : 1 : 1 / 128]
    size = np.maximum(np.hypot(x, y), 1)
    x, y = x / size, y / size
    z = np.sqrt(np.maximum(0, 1 - x * x - y * y))
    light = np.array([-0.35, 0.45, 0.82])
    light /= np.linalg.norm(light)
    shade = linear(np.minimum(1, 0.62 + 0.42 * np.maximum(0, x * light[0] + y * light[1] + z * light[2])))
    return [shade[..., None] * np.eye(4, 3)[k] for k in range(4)]


def linear(colours: FloatArray) -> FloatArray:
    """Colours that polyscope, which applies a gamma of 2.2 at the end, shows as the given ones."""
    return colours**2.2
