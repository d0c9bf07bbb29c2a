"""Draw the figure of docs/guide/angles_or_areas.md: three bodies at five balances, as checkerboard and as sphere.

    python -m benchmarks angles_or_areas
"""

from __future__ import annotations

import numpy as np
from matplotlib.collections import PolyCollection
from PIL import Image

import igl_spheremap as ism
from igl_spheremap.draw.plot import pose

from .common import IMAGES, pyplot

BODIES, BALANCES = ("dino", "brain", "octopus"), (0, 0.25, 0.5, 0.75, 1)
LIGHT = np.array([0.3, 0.4, 0.87])


def draw(axes, positions, faces, tints):
    """Faces towards the reader (along z), shaded, the far ones first."""
    corners = positions[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1)
    normal /= np.where(length > 0, length, 1)[:, None]
    order = np.argsort(corners[:, :, 2].mean(axis=1))
    order = order[normal[order, 2] > 0]
    shade = 0.45 + 0.55 * np.clip(normal[order] @ LIGHT, 0, 1)
    tint = np.clip(shade[:, None] * tints[order], 0, 1)
    axes.add_collection(PolyCollection(corners[order, :, :2], facecolors=tint, edgecolors=tint, linewidths=0.15))
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.axis("off")


def colours(v, x, faces):
    """By the distance from the body's middle, darker on every other square of 15 degrees of the sphere."""
    distance = np.linalg.norm((v - v.mean(axis=0))[faces].mean(axis=1), axis=1)
    middle = x[faces].mean(axis=1)
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    longitude, latitude = np.arctan2(middle[:, 1], middle[:, 0]), np.arcsin(np.clip(middle[:, 2], -1, 1))
    odd = (np.floor(longitude * 12 / np.pi) + np.floor(latitude * 12 / np.pi)) % 2 == 1
    return pyplot().get_cmap("turbo")(distance / distance.max())[:, :3] * np.where(odd, 0.55, 1)[:, None]


def main(argv: list[str]) -> None:
    """Draw."""
    target = argv[0] if argv else IMAGES / "angles_or_areas.png"
    figure, grid = pyplot().subplots(2 * len(BODIES), len(BALANCES), figsize=(12, 14.5))
    for row, name in enumerate(BODIES):
        v, f = ism.samples.make(name, n_vertices=8000)
        turn = pose(v)
        for column, balance in enumerate(BALANCES):
            result = ism.balanced_spherical_map(v, f, balance)
            area, angle = np.abs(result.area_ratios()).mean(), np.abs(result.angle_differences()).mean()
            print(f"{name} {balance}: area {area:.3f}, angle {angle:.2f}, {result.certificate.folding_free}")
            shown = colours(v, result.sphere, f)
            body, sphere = grid[2 * row, column], grid[2 * row + 1, column]
            draw(body, v @ turn.T, f, shown)
            draw(sphere, result.sphere @ turn.T, f, shown)
            body.set_title(f"{name}, balance {balance}\n|log area| {area:.2f}, angles {angle:.1f} degrees", fontsize=9)
    figure.tight_layout()
    figure.savefig(target, dpi=75)
    with Image.open(target) as picture:  # 96 colours take a third of the bytes
        small = picture.convert("RGB").quantize(96, dither=Image.Dither.NONE)
    small.save(target, optimize=True)
