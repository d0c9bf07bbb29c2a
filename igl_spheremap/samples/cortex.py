"""A folded, cortex-like blob. Where no comment says otherwise its numbers are chosen by eye."""

from __future__ import annotations

import numpy as np

from ..errors import check_number
from ..gate import gate
from ..mesh.arrays import FloatArray, IntArray
from .implicit import SmoothUnion, limb, mesh_implicit

_AXES = np.array([1.3, 1.0, 0.95])  # half axes of the hull: front, side, top
_WAVES = 24  # plane waves that make the folds wander, their directions spread evenly
_WAVE_NUMBER = 7.5  # radians of each in a unit of length
_FOLDS = 15.0  # radians of phase in a unit of length: a sulcus every 2 pi
_MEANDER = 3.0  # radians of phase by which the folds wander
_SHARPNESS = 1.0  # of the sulci, against the gyri
_CROWDED = 26.0  # folds narrower than 2 pi over this become shallow
_FISSURE = 0.12  # half width of the fissure between the hemispheres
_STEEPEST = 3.0  # walls of the deepest folds, against the hull


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
    """An ellipsoid less the deeper of sulcus and fissure, scaled to be 1-Lipschitz."""
    ratio = np.linalg.norm(p / _AXES, axis=1)
    surface = p / np.maximum(ratio, 0.1)[:, None]
    phase, crowding = _phase(surface)
    shallow = 1.0 / (1.0 + (crowding / _CROWDED) ** 4)
    sulcus = depth * shallow * np.exp(_SHARPNESS * (np.cos(phase) - 1.0))
    fissure = (
        1.8
        * depth
        * np.exp(-((p[:, 1] / _FISSURE) ** 2))
        / (1.0 + np.exp(-(surface[:, 2] + 0.1) / 0.1))
    )
    return ((ratio - 1.0) * _AXES.min() + np.maximum(sulcus, fissure)) / _STEEPEST


def _phase(p: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Phase of the folds, rising along x with meanders from plane waves, and the size of its gradient."""
    k = np.arange(_WAVES)
    up, turn = 1.0 - (2.0 * k + 1.0) / _WAVES, np.pi * (3.0 - np.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - up**2)
    wave = _WAVE_NUMBER * np.stack([flat * np.cos(turn), flat * np.sin(turn), up], axis=1)
    # phases spread evenly, by the plastic number
    angle = p @ wave.T + 2.0 * np.pi * ((k * 0.7548776662) % 1.0)
    height = _MEANDER * np.sqrt(2.0 / _WAVES)
    gradient = [_FOLDS, 0.0, 0.0] - height * np.sin(angle) @ wave
    return _FOLDS * p[:, 0] + height * np.cos(angle).sum(axis=1), np.linalg.norm(gradient, axis=1)
