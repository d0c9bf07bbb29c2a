"""Landmarks that are moved to given points of the sphere, through maps without foldings."""

from __future__ import annotations

import numpy as np

from ...mesh.arrays import FloatArray
from ...newton.faces import FaceProblem
from ...newton.loop import LineSearch, newton
from ...sphere.rows import row_dots, tangent
from ...verify.signs import folded_faces
from .levels import Level
from .strain import sphere_strain

#: Radians that a landmark moves in a step at most, and below which a failed step ends the flow.
_LONGEST, _SHORTEST = 0.2, 1e-3
#: Width of the kernel, in chords: fields as wide as the sphere strain it least.
_WIDTH = 2.0
#: A landmark this near to its goal is put there.
_MET = 1e-9
#: Share of the diagonal that is added to the kernel's matrix, for landmarks that nearly coincide.
_RIDGE = 1e-9
#: Newton steps of the relaxation after each step of the flow, and the share of the energy below which a gain ends it.
_RELAXATIONS, _GAIN = 6, 0.03
#: Steps at most: half the sphere takes 16.
_STEPS = 150
#: How often faces are split, and their share: ten random landmarks of two bodies took up to five rounds.
_ROUNDS, _SPLIT = 6, 0.1


def meet(level: Level, y: FloatArray, goals: FloatArray) -> tuple[Level, FloatArray]:
    """Bring a level's landmarks to goals on the sphere without foldings, as far as that succeeds.

    Where landmarks are stuck the faces that are strained most are split, and the level that comes back has them: there
    need not be a triangulation by great circles with given edges and some vertices in given places.
    """
    y = _flow(level, y, goals)
    for _ in range(_ROUNDS):
        if (y[level.landmarks] == goals).all():
            break
        energy = sphere_strain(level)
        strain = energy.by_face(y) / energy.area
        level, y = level.split(y, strain > np.quantile(strain, 1 - _SPLIT))
        y = _flow(level, y, goals)
    return level, y


def _flow(level: Level, y: FloatArray, goals: FloatArray) -> FloatArray:
    """Move landmarks towards their goals until they are there, or no step succeeds.

    Each step follows a smooth field that carries landmarks along great circles, and is relaxed towards the sphere's
    least strain while landmarks are held. Those that meet their goals do so bit for bit.
    """
    at, energy = level.landmarks, sphere_strain(level)
    held = np.zeros(len(y), dtype=bool)
    held[at] = True
    relaxed = FaceProblem(energy, held=held)
    # steps strain more than they do once they are relaxed
    free = FaceProblem(energy, slack=3 * energy.area)
    longest = _LONGEST
    for _ in range(_STEPS):
        if longest < _SHORTEST or (y[at] == goals).all():
            break
        y = _relaxed(relaxed, level, y)
        left = _logarithm(y[at], goals)
        move = _field(y, y[at], left * min(1.0, longest / np.sqrt(row_dots(left, left).max())))
        trial = free.accept(y, move)
        z = trial.x.copy()
        near = np.abs(z[at] - goals).max(axis=1) < _MET
        z[at[near]] = goals[near]
        if np.isfinite(trial.value) and not folded_faces(z, level.map.faces).any():
            y = z
        else:
            longest /= 2
    return y


def _relaxed(problem: FaceProblem, level: Level, y: FloatArray) -> FloatArray:
    """Lower the strain by a few steps, landmarks held."""
    value = problem.value(y)
    for k, step in enumerate(newton(problem, LineSearch(level.system), y), 1):
        y, gain, value = step.x, (value - step.value) / value, step.value
        if k == _RELAXATIONS or gain < _GAIN:
            break
    return y


def _logarithm(y: FloatArray, goals: FloatArray) -> FloatArray:
    """Return tangent vectors at y that point along great circles to goals, and are as long as these arcs."""
    across = tangent(y, goals)
    length = np.sqrt(row_dots(across, across))
    angle = np.arctan2(length, row_dots(y, goals))
    return across * (angle / np.where(length > 0, length, 1.0))[:, None]


def _field(y: FloatArray, at: FloatArray, moves: FloatArray) -> FloatArray:
    """Interpolate a tangent field at y that has given values at some points, by kernels about these."""

    def kernel(x: FloatArray) -> FloatArray:
        distance = np.sqrt(np.maximum(2 - 2 * x @ at.T, 0)) / _WIDTH
        return np.asarray((1 + distance) * np.exp(-distance))  # Matern, 3/2

    K = kernel(at) + _RIDGE * np.eye(len(at))
    c = np.linalg.solve(K, moves)
    for _ in range(3):  # the field is made tangent, which changes it at the points
        c += np.linalg.solve(K, moves - tangent(at, K @ c))
    return tangent(y, kernel(y) @ c)
