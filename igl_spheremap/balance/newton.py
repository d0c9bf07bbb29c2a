"""Projected Newton steps for a balanced energy; every iterate is free of foldings."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..errors import FactorisationFailed
from ..mesh.arrays import FloatArray
from ..result.run import Iterate
from ..sphere.rows import row_crosses, tangent_axes, weighted_moment
from .derivatives import derivatives
from .energy import Energy
from .newton_system import NewtonSystem
from .step import certified_step

#: Share of the predicted decrease that a step must bring (Armijo).
_DECREASE = 1e-4
#: The run ends where steps must be shortened to less than this share of Newton's.
_SHORTEST = 1e-3
#: Where steps are shortened, the gains of this many of them must be small before the run has converged.
_PATIENCE = 3
#: Bound on the ratio of the last two gains: their geometric series must converge.
_LARGEST_RATIO = 0.9


def newton(energy: Energy, system: NewtonSystem, x: FloatArray, stage: str) -> Iterator[Iterate]:
    """Iterates from a map free of foldings; the residual is the share of the energy that is still to gain.

    After a full step that is the geometric series of the last two gains, after a shortened one the largest of the last.
    """
    by_face = energy.by_face(x)
    value, length, gains = float(by_face.sum()), 1.0, [1.0] * _PATIENCE
    at_zero = value < np.finfo(float).eps * energy.source.area.sum()
    yield Iterate(stage, 0, 0, x, value, 0.0 if at_zero else np.inf)
    while True:
        axes = np.ascontiguousarray(np.stack(tangent_axes(x)).transpose(0, 2, 1))  # axis, coordinate, vertex
        slope = derivatives(energy, x, axes)
        try:
            step = system.step(slope)
        except FactorisationFailed:
            return
        decrease = -_DECREASE * float((slope.gradient * step).sum())
        move = _without_rotation(x, np.einsum("an,ain->ni", step, axes))
        length = min(1.0, 2 * length)
        while (trial := certified_step(energy, x, length * move, by_face)) is None \
                or not trial[1].sum() < value - length * decrease:
            length /= 2
            if length < _SHORTEST:
                return
        x, by_face = trial
        previous, value = value, float(by_face.sum())
        gains.append((previous - value) / value)
        ratio = min(gains[-1] / gains[-2], _LARGEST_RATIO)
        residual = gains[-1] * ratio / (1 - ratio) if length == 1 else max(gains[-_PATIENCE:])
        yield Iterate(stage, 0, len(gains) - _PATIENCE, x, value, residual, length)


def _without_rotation(x: FloatArray, move: FloatArray) -> FloatArray:
    """The move less the rotation nearest to it, which changes no energy but strains along straight lines."""
    inertia = len(x) * np.eye(3) - weighted_moment(np.ones(len(x)), x, x)
    turn = np.linalg.solve(inertia, row_crosses(x, move).sum(axis=0))
    return np.asarray(move - row_crosses(np.broadcast_to(turn, x.shape), x))
