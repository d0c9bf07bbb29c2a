"""A folded, cortex-like blob. Unless a comment says otherwise, its numbers are chosen by eye."""

from __future__ import annotations

import numpy as np

from ..errors import check_number
from ..gate import gate
from ..mesh.arrays import FloatArray, IntArray
from .implicit import SmoothUnion, limb, mesh_implicit

_AXES = np.array([1.3, 1.0, 0.95])  # half axes of the hull: front, side, top


@gate
def brain(n_vertices: int = 20000, depth: float = 0.15) -> tuple[FloatArray, IntArray]:
    """Two hemispheres with gyri and sulci, a cerebellum and a stem.

    `n_vertices` and the result are those of every sample, see `igl_spheremap.samples`.

    Parameters
    ----------
    depth : float
        Depth of the sulci, where the brain is 2.6 long; 0 to 0.17.
    """
    check_number(depth, "depth", 0.0, 0.17)
    stem = limb([(-0.3, 0, -0.5, 0.25), (-0.45, 0, -1.0, 0.2), (-0.6, 0, -1.4, 0.17)])
    cerebellum = [
        limb([(-0.8, 0.1 * y, -0.7, 0.33), (-0.8, 0.4 * y, -0.67, 0.33)]) for y in (1, -1)
    ]
    lower = SmoothUnion((stem, *cerebellum), blend=0.04)

    def field(p: FloatArray) -> FloatArray:
        below = lower(p)
        # beneath the cerebellum a sulcus would be a tunnel
        open_air = np.clip((below - 0.05) / 0.2, 0.0, 1.0)
        return np.minimum(_cerebrum(p, depth * open_air), below)

    box = np.stack([np.minimum(-1.1 * _AXES, lower.box()[0]), 1.1 * _AXES])
    return mesh_implicit(field, box, n_vertices, detail=0.05)


def _cerebrum(p: FloatArray, depth: FloatArray) -> FloatArray:
    """An ellipsoid less the deeper of sulcus and fissure, scaled by its steepest walls to be 1-Lipschitz."""
    ratio = np.linalg.norm(p / _AXES, axis=1)
    surface = p / np.maximum(ratio, 0.1)[:, None]
    phase, crowding = _phase(surface)
    shallow = 1.0 / (1.0 + (crowding / 26.0) ** 4)  # folds narrower than 2 pi / 26 are
    sulcus = depth * shallow * np.exp(np.cos(phase) - 1.0)
    half_width = 0.12
    fissure = (
        1.8
        * depth
        * np.exp(-((p[:, 1] / half_width) ** 2))
        / (1.0 + np.exp(-(surface[:, 2] + 0.1) / 0.1))
    )
    return ((ratio - 1.0) * _AXES.min() + np.maximum(sulcus, fissure)) / 3.0


def _phase(
    p: FloatArray,
    folds: float = 15.0,
    waves: int = 24,
    wave_number: float = 7.5,
    meander: float = 3.0,
) -> tuple[FloatArray, FloatArray]:
    """Phase of the folds, rising along x with meanders from plane waves, and the size of its gradient.

    A sulcus comes every 2 pi, and `folds` radians in a unit of length. Plane waves of a `wave_number`, in directions
    spread evenly, make it wander by `meander` radians.
    """
    k = np.arange(waves)
    up, turn = 1.0 - (2.0 * k + 1.0) / waves, np.pi * (3.0 - np.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - up**2)
    wave = wave_number * np.stack([flat * np.cos(turn), flat * np.sin(turn), up], axis=1)
    # phases spread evenly, by the plastic number
    angle = p @ wave.T + 2.0 * np.pi * ((k * 0.7548776662) % 1.0)
    height = meander * np.sqrt(2.0 / waves)
    gradient = [folds, 0.0, 0.0] - height * np.sin(angle) @ wave
    return folds * p[:, 0] + height * np.cos(angle).sum(axis=1), np.linalg.norm(gradient, axis=1)
