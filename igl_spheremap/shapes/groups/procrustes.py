"""Generalised Procrustes: shapes of corresponding points moved, turned and scaled until they agree best."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...mesh.arrays import ROUNDING, FloatArray
from ...sphere.moebius import best_rotation
from ...sphere.rows import weighted_moment, weighted_sum


class Alignment(NamedTuple):
    """Shapes aligned with each other by generalised Procrustes.

    Attributes
    ----------
    shapes : (k, n, 3) float64 array
        Each moved, turned and divided by its size, beside the mean of the centres.
    mean : (n, 3) float64 array
        Mean of the shapes at the mean place, in the mean pose and, unless they are rigid, of the mean size.
    sizes : (k,) float64 array
        Size of each beside the geometric mean of all; 1 if they are rigid.
    distances : (k,) float64 array
        Root mean square distance of each from the mean.
    """

    shapes: FloatArray
    mean: FloatArray
    sizes: FloatArray
    distances: FloatArray


def generalised_procrustes(
    shapes: FloatArray, weights: FloatArray, rigid: bool = False, steps: int = 100
) -> Alignment:
    """Align shapes (k, n, 3) with each other: no one of them is the reference.

    The mean lies where the shapes lie on average, and is turned as they are: rotations have the identity as their mean.

    >>> square = np.array([[1.0, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]])
    >>> generalised_procrustes(np.stack((square, 4 * square)), np.ones(4)).mean.round(9)[0].tolist()
    [2.0, 2.0, 0.0]
    """
    weights = weights / weights.sum()
    centres = np.stack([weighted_sum(weights, shape) for shape in shapes])
    own = shapes - centres[:, None]
    radii = np.sqrt([weights @ (shape**2).sum(axis=1) for shape in own])
    sizes = np.ones(len(shapes))
    if not rigid:
        sizes = radii / np.exp(np.log(radii).mean())
    own /= sizes[:, None, None]
    mean = own[0]
    for _ in range(steps):
        rotations = np.stack([best_rotation(shape, mean, weights) for shape in own])
        before, mean = mean, (own @ rotations).mean(axis=0)
        if np.abs(mean - before).max() < ROUNDING * radii.max():
            break
    pose = best_rotation(np.eye(3), rotations.sum(axis=0).T, np.ones(3))
    centre = centres.mean(axis=0)
    aligned, mean = own @ (rotations @ pose) + centre, mean @ pose + centre
    return Alignment(aligned, mean, sizes, np.sqrt(((aligned - mean) ** 2).sum(axis=2) @ weights))


def fitted(
    shape: FloatArray, mean: FloatArray, weights: FloatArray, size: float | None = None
) -> tuple[FloatArray, float]:
    """One shape fitted to a mean that is held fixed, and the size that it was divided by, which may be given."""
    weights = weights / weights.sum()
    centre, goal = weighted_sum(weights, shape), weighted_sum(weights, mean)
    own, theirs = shape - centre, mean - goal
    if size is None:
        radius, other = (
            np.sqrt(np.trace(weighted_moment(weights, each, each))) for each in (own, theirs)
        )
        size = float(radius / other)
    return own @ best_rotation(own, theirs, weights) / size + goal, size
