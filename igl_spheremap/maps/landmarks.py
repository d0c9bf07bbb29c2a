"""Landmark matching: a quadratic penalty on where chosen vertices go."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import least_squares

from ..errors import MeshError
from ..mesh.check import check_rows
from ..sphere.gauge import best_rotation
from ..sphere.moebius import moebius
from ..sphere.rows import unit_rows

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class LandmarkEnergy:
    """Half the weighted sum of the squared chords between landmarks and their targets.

    Attributes
    ----------
    vertices : (k,) int64 array
        The landmarks.
    targets : (k, 3) float64 array
        Where each ought to be, unit rows.
    weights : (k,) float64 array
        Non-negative.
    """

    vertices: IntArray
    targets: FloatArray
    weights: FloatArray

    def evaluate(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Value and derivatives.

        Parameters
        ----------
        x : (n, 3) float64 array
            The map.

        Returns
        -------
        energy : float
        gradient : (n, 3) float64 array
            Zero but at landmarks.
        """
        off = x[self.vertices] - self.targets
        gradient = np.zeros_like(x)
        np.add.at(gradient, self.vertices, self.weights[:, None] * off)
        return 0.5 * float(self.weights @ np.einsum("ij,ij->i", off, off)), gradient


def check_landmarks(n: int, vertices: ArrayLike, targets: ArrayLike, weights: ArrayLike) -> LandmarkEnergy:
    """Check landmarks at the gate.

    Parameters
    ----------
    n : int
        Number of vertices of the mesh.
    vertices : (k,) array_like
        Vertex indices.
    targets : (k, 3) array_like
        Directions; rows are scaled to unit length.
    weights : float or (k,) array_like
        Non-negative.

    Returns
    -------
    LandmarkEnergy
        In float64.

    Raises
    ------
    MeshError
        One line that says which landmark is wrong, and why.

    Examples
    --------
    >>> check_landmarks(4, [0, 2], [[0, 0, 2], [1, 0, 0]], 3.0).targets
    array([[0., 0., 1.],
           [1., 0., 0.]])
    """
    index = np.asarray(vertices)
    if index.ndim != 1 or not len(index) or index.dtype.kind not in "iu":
        raise MeshError("landmarks are no list of vertex indices; give one whole number each, at least one")
    bad = np.flatnonzero((index < 0) | (index >= n))
    if len(bad):
        raise MeshError(
            f"landmark {bad[0]} is vertex {index[bad[0]]}, but the mesh has vertices 0 to {n - 1}"
        )
    y = check_rows(targets, len(index), "landmark targets")
    length = np.linalg.norm(y, axis=1)
    bad = np.flatnonzero(~np.isfinite(length) | (length == 0))
    if len(bad):
        raise MeshError(f"the target of landmark {bad[0]} is zero or not finite; give a direction")
    w = np.broadcast_to(np.asarray(weights, dtype=np.float64), index.shape)
    bad = np.flatnonzero(~np.isfinite(w) | (w < 0))
    if len(bad):
        raise MeshError(f"the weight of landmark {bad[0]} is {w[bad[0]]:g}; give a finite one, not negative")
    return LandmarkEnergy(index.astype(np.int64), unit_rows(y), w)


def match_landmarks(x: FloatArray, landmarks: LandmarkEnergy, stiffness: float = 1e-3) -> FloatArray:
    """Moebius map of `x` that brings landmarks closest to their targets.

    Parameters
    ----------
    x : (n, 3) float64 array
        Unit rows.
    landmarks : LandmarkEnergy
        Where to bring which vertices.
    stiffness : float
        Weight of the squared length of the boost against the mean squared miss: keeps few landmarks, which
        strong boosts match exactly, from crowding everything else.

    Returns
    -------
    (n, 3) float64 array
        Unit rows: as conformal as `x`.

    Examples
    --------
    >>> import numpy as np
    >>> x = np.vstack((np.eye(3), -np.eye(3)))
    >>> goal = check_landmarks(6, np.arange(6), moebius(x, [0.1, 0.3, 0.0]), 1.0)
    >>> found = match_landmarks(x, goal, stiffness=0.0)
    >>> bool(np.allclose(found, goal.targets, atol=1e-6))
    True
    """
    w = landmarks.weights + np.finfo(float).tiny
    share = np.sqrt(w / w.sum())[:, None]

    def moved(points: FloatArray, boost: FloatArray) -> FloatArray:
        size = float(np.linalg.norm(boost))
        return moebius(points, boost * (np.tanh(size) / size if size else 1.0) * (1 - 1e-12))

    def misses(boost: FloatArray) -> FloatArray:
        y = moved(x[landmarks.vertices], boost)
        y = y @ best_rotation(y, landmarks.targets, w)
        return np.append((share * (y - landmarks.targets)).ravel(), np.sqrt(stiffness) * boost)

    boost = least_squares(misses, np.zeros(3)).x
    y = moved(x, boost)
    return unit_rows(y @ best_rotation(y[landmarks.vertices], landmarks.targets, w))
