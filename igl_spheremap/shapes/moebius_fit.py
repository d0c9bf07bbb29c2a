"""The Moebius map that brings one surface's features closest to another's."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from ..mesh.arrays import FloatArray, IntArray
from ..sphere.moebius import moebius
from ..verify.signs import folded_faces
from .features import Picture

#: Takes each iterate and its cost.
Notify = Callable[[FloatArray, float], None]

#: Penalty on the squared boost of a step, beside features of unit variance: boosts that these leave open stay short.
_RIDGE = 0.05
#: The iteration ends at a gain below this share of the variance.
_SMALLEST_GAIN = 1e-7


def fit_moebius(
    x: FloatArray, f: IntArray, weights: FloatArray, features: FloatArray, fixed: Picture, notify: Notify
) -> None:
    """Lower the weighted square of features - fixed(x) by Gauss-Newton steps in the six directions of Moebius maps.

    The features (n, k) have unit variance, the weights sum 1. A step that folds a face is shortened: the map moves
    vertices, not edges, and slivers can flip.
    """
    damping = 1e-3
    values, gradients = fixed(x)
    cost = misfit(weights, features - values)
    for _ in range(30):
        # The fields w cross x of rotations and c - (c . x) x of boosts towards c.
        turns = np.cross(x[:, None], gradients)
        J = np.concatenate((turns, gradients), axis=2)
        H = np.einsum("n,nki,nkj->ij", weights, J, J)
        H[3:, 3:] += _RIDGE * np.eye(3)
        slope = np.einsum("n,nki,nk->i", weights, J, features - values)
        while True:
            step = np.linalg.solve(H + damping * np.trace(H) / 6 * np.eye(6), slope)
            y = _moved(x, step)
            new_values, new_gradients = fixed(y)
            gain = cost - misfit(weights, features - new_values)
            if gain > 0 and not folded_faces(y, f).any():
                break
            damping *= 4
            if damping > 1e6:
                return
        x, values, gradients, cost, damping = y, new_values, new_gradients, cost - gain, max(damping / 6, 1e-6)
        notify(x, cost)
        if gain < _SMALLEST_GAIN * features.shape[1]:
            break


def misfit(weights: FloatArray, off: FloatArray) -> float:
    """Sum of the weighted squares."""
    return float(np.einsum("n,nk,nk->", weights, off, off))


def _moved(x: FloatArray, step: FloatArray) -> FloatArray:
    """x boosted by the last three entries, then rotated by the first three."""
    boost = step[3:]
    length = float(np.linalg.norm(boost))
    centre = -boost * (np.tanh(length / 2) / length if length else 0.0)
    return moebius(x, centre) @ Rotation.from_rotvec(step[:3]).as_matrix().T
