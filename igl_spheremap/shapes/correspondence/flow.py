"""Landmarks that are moved to given points of the sphere, through maps without foldings."""

from __future__ import annotations

import numpy as np

from ...mesh.arrays import FloatArray
from ...mesh.edges import marked
from ...newton.faces import FaceProblem
from ...newton.loop import LineSearch, newton
from ...sphere.rows import row_dots, tangent
from ...verify.signs import folded_faces
from .levels import Level
from .strain import sphere_strain


def meet(
    level: Level, y: FloatArray, goals: FloatArray, rounds: int = 6, share: float = 0.1
) -> tuple[Level, FloatArray]:
    """Bring a level's landmarks to goals on the sphere, or as near as possible, without foldings.

    If landmarks are stuck, the most strained `share` of the faces is split, and the returned level has their parts.
    There need not be a triangulation by great circles with given edges and some vertices in given places.
    """
    y = _flow(level, y, goals)
    for _ in range(rounds):
        if (y[level.landmarks] == goals).all():
            break
        energy = sphere_strain(level)
        strain = energy.by_face(y) / energy.area
        level, y = level.split(y, strain > np.quantile(strain, 1 - share))
        y = _flow(level, y, goals)
    return level, y


def _flow(
    level: Level,
    y: FloatArray,
    goals: FloatArray,
    *,
    longest: float = 0.2,
    shortest: float = 1e-3,
    met: float = 1e-9,
    steps: int = 150,
) -> FloatArray:
    """Move landmarks towards their goals until they are there, or no step succeeds.

    Each step follows a smooth field that carries landmarks along great circles, and is relaxed towards the sphere's
    least strain while landmarks are held. Landmarks move by `longest` radians at most, half as much after a step that
    fails. Landmarks as near as `met` meet their goals bit for bit. Half the sphere takes 16 steps.
    """
    at, energy = level.landmarks, sphere_strain(level)
    relaxed = FaceProblem(energy, held=marked(at, len(y)))
    # relaxation lowers the strain of steps
    free = FaceProblem(energy, slack=3 * energy.area)
    for _ in range(steps):
        if longest < shortest or (y[at] == goals).all():
            break
        y = _relaxed(relaxed, level, y)
        left = _logarithm(y[at], goals)
        move = _field(y, y[at], left * min(1.0, longest / np.sqrt(row_dots(left, left).max())))
        trial = free.accept(y, move)
        z = trial.x.copy()
        near = np.abs(z[at] - goals).max(axis=1) < met
        z[at[near]] = goals[near]
        if np.isfinite(trial.value) and not folded_faces(z, level.map.faces).any():
            y = z
        else:
            longest /= 2
    return y


def _relaxed(
    problem: FaceProblem, level: Level, y: FloatArray, steps: int = 6, enough: float = 0.03
) -> FloatArray:
    """Lower the strain by a few steps, landmarks held, while they gain `enough` of it."""
    value = problem.value(y)
    for k, step in enumerate(newton(problem, LineSearch(level.system), y), 1):
        y, gain, value = step.x, (value - step.value) / value, step.value
        if k == steps or gain < enough:
            break
    return y


def _logarithm(y: FloatArray, goals: FloatArray) -> FloatArray:
    """Return tangent vectors at y that point along great circles to goals, and are as long as these arcs."""
    across = tangent(y, goals)
    length = np.sqrt(row_dots(across, across))
    angle = np.arctan2(length, row_dots(y, goals))
    return across * (angle / np.where(length > 0, length, 1.0))[:, None]


def _field(
    y: FloatArray, at: FloatArray, moves: FloatArray, width: float = 2.0, ridge: float = 1e-9
) -> FloatArray:
    """Interpolate a tangent field at y that has given values at some points, by kernels about these.

    Fields as wide as the sphere, 2 in chords, strain it least; the ridge is for points that nearly coincide.
    """

    def kernel(x: FloatArray) -> FloatArray:
        distance = np.sqrt(np.maximum(2 - 2 * x @ at.T, 0)) / width
        return (1 + distance) * np.exp(-distance)  # Matern, 3/2

    K = kernel(at) + ridge * np.eye(len(at))
    c = np.linalg.solve(K, moves)
    for _ in range(3):  # the field is made tangent, which changes it at the points
        c += np.linalg.solve(K, moves - tangent(at, K @ c))
    return tangent(y, kernel(y) @ c)
