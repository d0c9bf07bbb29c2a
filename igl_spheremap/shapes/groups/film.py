"""Films of a group's modes, and of a series: animated .gif files, all frames of one scale; they need Pillow."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...draw.palette import Ramp, areas, round_up, sequential, sizes
from ...draw.plot import frame, pose, raster, shading
from ...errors import import_optional
from ...io.replacing import replacing
from ...mesh.arrays import FloatArray, IntArray
from .group import Group
from .series import Series

#: Standard deviations that films and pictures of a mode go to either side.
REACH = 2.0
_SIZE = 320  # pixels of a side; a film of a series shows two bodies side by side
_FRAMES = 24  # of a mode: to one end, to the other and back
_MOST = 200  # frames of a series, evenly chosen
_PAUSE = 80  # milliseconds of a mode's frames; a series that has fewer is as long
_LENGTH = _FRAMES * _PAUSE


def write_mode_film(path: str | os.PathLike[str], group: Group, mode: int = 0) -> None:
    """Write a mode from -2 to +2 standard deviations and back."""
    turn, away = pose(group.vertices).T, movement(group, mode)
    colours = sizes("movement", round_up(float(away.max()))).colours(away[group.faces].mean(axis=1))
    scores = REACH * np.sqrt(group.variances[mode]) * np.sin(np.linspace(0, 2 * np.pi, _FRAMES, endpoint=False))
    bodies = [group.shape(np.append(np.zeros(mode), score)) @ turn for score in scores]
    _save(path, _pictures(bodies, group.faces, [colours] * len(bodies)), _PAUSE)


def write_series_film(path: str | os.PathLike[str], found: Series, mean: FloatArray) -> None:
    """Write the frames, and beside them the mean surface, in the colours of `over_time`."""
    values, ramp = over_time(found)
    chosen = np.unique(np.linspace(0, len(values) - 1, min(_MOST, len(values))).round().astype(int))
    turn = pose(mean).T
    colours = [ramp.colours(values[k][found.faces].mean(axis=1)) for k in chosen]
    left = _pictures([shape @ turn for shape in found.aligned[chosen]], found.faces, colours)
    right = _pictures([mean @ turn] * len(chosen), found.faces, colours)
    both = [np.concatenate(pair, axis=1) for pair in zip(left, right, strict=True)]
    _save(path, both, max(_PAUSE, _LENGTH // len(both)))


def over_time(found: Series, feature: str = "") -> tuple[FloatArray, Ramp]:
    """The first feature (frames, n), whose name is given, and its colours.

    Without features these are the logarithms of the areas around the points over their mean in time.
    """
    if found.features.shape[2]:
        values = found.features[:, :, 0]
        return values, sequential(feature, *np.percentile(values, [1, 99]).tolist())
    values = np.log(found.areas / found.areas.mean(axis=0))
    most = round_up(float(np.expm1(np.percentile(np.abs(values), 99))))
    return values, replace(areas(1 + most), label="area / its mean in time")


def movement(group: Group, mode: int) -> FloatArray:
    """How far a standard deviation of a mode moves each vertex."""
    return np.asarray(np.linalg.norm(group.modes[mode], axis=1) * np.sqrt(group.variances[mode]))


def _pictures(bodies: Sequence[FloatArray], f: IntArray, colours: Sequence[FloatArray]) -> list[NDArray[np.uint8]]:
    """Bodies as they are seen along -z, in face colours, in the light, all in one square."""
    shown = frame(np.concatenate(bodies))
    light = [shading(v, f, np.eye(3))[:, None] for v in bodies]
    return [raster(v, f, colour * each, _SIZE, shown=shown)
            for v, colour, each in zip(bodies, colours, light, strict=True)]


def _save(path: str | os.PathLike[str], pictures: Sequence[NDArray[np.uint8]], pause: int) -> None:
    images = import_optional("PIL.Image", "a film", "io")
    first, *others = [images.fromarray(picture) for picture in pictures]
    with replacing(path, force=True) as partial:
        first.save(Path(partial), "GIF", save_all=True, append_images=others, duration=pause, loop=0)
