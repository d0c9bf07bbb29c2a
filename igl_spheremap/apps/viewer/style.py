"""Light and colours as polyscope takes them."""

from __future__ import annotations

import numpy as np

from ...draw.raster import LIGHT
from ...mesh.arrays import FloatArray


def matcaps() -> list[FloatArray]:
    """Images (256, 256, 3) of a lit ball in red, green, blue and black, which make a blendable material of polyscope.

    The light comes from the viewer's upper left. A colour c is seen as c times the shade: polyscope's own
    materials would wash it out, and then no legend fits.
    """
    y, x = np.mgrid[1 - 1 / 256 : -1 : -1 / 128, -1 + 1 / 256 : 1 : 1 / 128]
    size = np.maximum(np.hypot(x, y), 1)
    x, y = x / size, y / size
    z = np.sqrt(np.maximum(0, 1 - x * x - y * y))
    shade = linear(np.minimum(1, 0.62 + 0.42 * np.maximum(0, np.stack((x, y, z), axis=2) @ LIGHT)))
    return [shade[..., None] * np.eye(4, 3)[k] for k in range(4)]


def linear(colours: FloatArray) -> FloatArray:
    """Colours that polyscope, which applies a gamma of 2.2 at the end, shows as the given ones."""
    return colours**2.2
