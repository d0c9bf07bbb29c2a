"""Generalised Procrustes: shapes of corresponding points moved, turned and scaled until they agree best."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ...mesh.arrays import FloatArray
from ...sphere.moebius import best_rotation
from ...sphere.rows import weighted_moment, weighted_sum

_STEPS, _TOLERANCE = 100, 1e-12  # at most, and the move of the mean that ends them
_BLOCK = 1 << 21  # numbers that are in memory at a time: 16 MB, of which a step needs a few


def blocks(shapes: FloatArray) -> Iterator[slice]:
    """Parts of shapes (k, n, 3) that may lie in a file; they depend on the sizes only, and so do sums over them."""
    size = max(1, _BLOCK // (3 * shapes.shape[1]))
    return (slice(k, min(k + size, len(shapes))) for k in range(0, len(shapes), size))


class Alignment(NamedTuple):
    """Generalised Procrustes of shapes, which `laid` lays on each other.

    Attributes
    ----------
    mean : (n, 3) float64 array
        Mean of the shapes at the mean place, in the mean pose and, unless they are rigid, of the mean size.
    sizes : (k,) float64 array
        Size of each beside the geometric mean of all; 1 if they are rigid.
    rotations : (k, 3, 3) float64 array
        Those that multiply rows from the right.
    centres : (k, 3) float64 array
        Weighted means of the points as they came.
    """

    mean: FloatArray
    sizes: FloatArray
    rotations: FloatArray
    centres: FloatArray

    def laid(self, shapes: FloatArray, part: slice = slice(None)) -> FloatArray:
        """Some of the shapes: ``(shapes[k] - centres[k]) @ rotations[k] / sizes[k]`` beside the mean of the centres."""
        centred = (shapes[part] - self.centres[part, None]) / self.sizes[part, None, None]
        return centred @ self.rotations[part] + self.centres.mean(axis=0)


def generalised_procrustes(shapes: FloatArray, weights: FloatArray, rigid: bool = False) -> Alignment:
    """Align shapes (k, n, 3), which may lie in a file, with each other: no one of them is the reference.

    The mean lies where the shapes lie on average, and is turned as they are: rotations have the identity as their mean.

    >>> square = np.array([[1.0, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]])
    >>> generalised_procrustes(np.stack((square, 4 * square)), np.ones(4)).mean.round(9)[0].tolist()
    [2.0, 2.0, 0.0]
    """
    weights = weights / weights.sum()
    centres = np.stack([weighted_sum(weights, shape) for shape in shapes])
    radii = np.sqrt([weights @ ((shape - centre) ** 2).sum(axis=1)
                     for shape, centre in zip(shapes, centres, strict=True)])
    sizes = np.ones(len(shapes)) if rigid else radii / np.exp(np.log(radii).mean())
    rotations = np.tile(np.eye(3), (len(shapes), 1, 1))
    mean = (shapes[0] - centres[0]) / sizes[0]
    for _ in range(_STEPS):
        total = np.zeros_like(mean)
        for part in blocks(shapes):
            centred = (shapes[part] - centres[part, None]) / sizes[part, None, None]
            rotations[part] = [best_rotation(shape, mean, weights) for shape in centred]
            total += (centred @ rotations[part]).sum(axis=0)
        before, mean = mean, total / len(shapes)
        if np.abs(mean - before).max() < _TOLERANCE * radii.max():
            break
    pose = best_rotation(np.eye(3), rotations.sum(axis=0).T, np.ones(3))
    return Alignment(mean @ pose + centres.mean(axis=0), sizes, rotations @ pose, centres)


def placed(shape: FloatArray, mean: FloatArray, weights: FloatArray, size: float | None = None) -> tuple[
        FloatArray, float]:
    """One shape laid on a mean that stays where it is, and its size, which may be given."""
    weights = weights / weights.sum()
    centre, goal = weighted_sum(weights, shape), weighted_sum(weights, mean)
    own, theirs = shape - centre, mean - goal
    radius, other = (np.sqrt(np.trace(weighted_moment(weights, each, each))) for each in (own, theirs))
    size = float(radius / other) if size is None else size
    return own @ best_rotation(own, theirs, weights) / size + goal, size
