"""Confidence of labels that points take from a mapped surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from ...errors import check_number
from ...gate import gate
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray, check_directions
from ...resampling.transfer import transfer
from ...sphere.rows import tangent_axes, unit_rows

#: Points in rings around the one that takes a label. Each of the 19 stands for an equal share of the Gaussian, so that
#: margins are multiples of 1/19, some five percent.
_RINGS = (6, 12)


@gate
def label_margin(
    source: SphereMap, labels: ArrayLike, points: ArrayLike, width: float
) -> tuple[IntArray, FloatArray]:
    """Labels at points of the sphere, and their margins over the next ones if points are off.

    Each point takes the label of the corner with the largest weight in its face, as `transfer` of labels does. The
    weight of a label is the share of a Gaussian about the point that lies on it.

    Parameters
    ----------
    source : SphereMap
        Surface of the labels.
    labels : (n,) array_like of int
        At its vertices.
    points : (k, 3) array_like
        Directions.
    width : float
        Standard deviation of the points' errors along each axis, in radians. Their median distance is 1.18 times that.

    Returns
    -------
    labels : (k,) int64 array
        At the points.
    margin : (k,) float64 array
        Weight of the label less that of the next one: 1 if there is no other nearby, 0 if another one has as much.

    Raises
    ------
    MeshError
        If there is not one label per vertex, or points are not finite, nonzero rows of three.
    ValueError
        If the width is below 0.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> from igl_spheremap.shapes.cortices.labels import label_margin
    >>> x, f = ism.samples.sphere(642)
    >>> sides = (x[:, 0] > 0).astype(int)
    >>> found, margin = label_margin(ism.sphere_map(x, f, x), sides, [[1, 0, 0], [0.05, 1, 0]], width=0.1)
    >>> found.tolist(), float(margin[0]), bool(margin[1] < 0.6)
    ([1, 1], 1.0, True)
    """
    check_number(width, "width")
    x = unit_rows(check_directions(points, name="points"))
    own = np.asarray(transfer(source, labels, x, labels=True), dtype=np.int64)
    axes = tangent_axes(x)
    nearest, total = cKDTree(source.sphere), 1 + sum(_RINGS)
    votes, within = [own], 1
    for count in _RINGS:
        # half of the ring's share lies within
        radius = width * np.sqrt(-2 * np.log1p(-(within + count / 2) / total))
        within += count
        for angle in 2 * np.pi * np.arange(count) / count:
            step = radius * (np.cos(angle) * axes[0] + np.sin(angle) * axes[1])
            votes.append(np.asarray(labels, dtype=np.int64)[nearest.query(unit_rows(x + step))[1]])
    found = np.stack(votes, axis=1)
    weights = np.stack([(found == column[:, None]).sum(axis=1) for column in votes], axis=1)
    second = np.where(found == own[:, None], 0, weights).max(axis=1)
    return own, np.maximum(weights[:, 0] - second, 0) / total
