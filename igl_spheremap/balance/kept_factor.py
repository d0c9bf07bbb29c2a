"""Newton steps; if little is left to gain, one may use the factor of the step before."""

from __future__ import annotations

import numpy as np

from ..mesh.arrays import ComplexArray, FloatArray, IntArray
from ..newton.loop import LineSearch, Model, NewtonProblem, Trial
from ..newton.system import VertexSystem
from ..operators.factor.factor import Factor


class KeptFactor(LineSearch):
    """A line search that uses the last factor again for a step that is predicted to gain less than a share.

    That factor must have predicted the gain of the last step well.

    Attributes
    ----------
    tolerance : float
        That share.
    ahead : float
        If the last step used an old factor, its predicted gain, as a share of the value; else infinite.
    """

    #: A good prediction of a step's gain is off by less than this share.
    faithful = 0.15
    #: Gains fall quadratically: the next one is below t only if the square of the last is below this times t.
    squares = 10.0

    def __init__(self, system: VertexSystem, tolerance: float) -> None:
        super().__init__(system)
        self.tolerance, self.ahead = tolerance, np.inf
        # of a map, with its axes and value
        self._kept: tuple[Factor, FloatArray, FloatArray, float] | None = None

    def step(self, problem: NewtonProblem, x: FloatArray, model: Model) -> Trial | None:
        """A step with the old factor; if that is not enough, with a new one."""
        if (trial := self._last_step(problem, x, model)) is not None:
            return trial
        return super().step(problem, x, model)

    def search(
        self, problem: NewtonProblem, x: FloatArray, model: Model, factor: Factor
    ) -> Trial | None:
        """The search of the base, which keeps the factor of a whole step that was predicted well."""
        trial, self._kept = super().search(problem, x, model, factor), None
        if trial is not None:
            off = abs(model.value - trial.value - self.predicted)
            if self.length == 1 and off < self.faithful * abs(self.predicted):
                self._kept = factor, x, model.axes, model.value
        return trial

    def _last_step(self, problem: NewtonProblem, x: FloatArray, model: Model) -> Trial | None:
        """A step with the factor of the last one; None unless its gain would be below the tolerance.

        Since then the map has turned and grown around each vertex, by a complex factor c: step = c H^-1 (conj(c) g).
        """
        self.ahead = np.inf
        if self._kept is None:
            return None
        factor, before, axes, value = self._kept
        if (value / model.value - 1) ** 2 > self.squares * self.tolerance:
            return None
        c = _turned(self.system.f, before, axes, x, model.axes)
        load = c.conj() * (model.gradient[0] + 1j * model.gradient[1])
        solved = self.system.solve(factor, np.stack((load.real, load.imag)))
        turned = -c * (solved[0] + 1j * solved[1])  # balance (11)
        step = np.stack((turned.real, turned.imag))
        predicted = -float((model.gradient * step).sum()) / 2
        if not predicted < self.tolerance * model.value:
            return None
        trial = problem.accept(x, problem.move(x, model, step))
        if not trial.value < model.value:
            return None
        self.ahead = predicted / model.value
        return trial


def _turned(
    f: IntArray, x: FloatArray, axes: FloatArray, y: FloatArray, other: FloatArray
) -> ComplexArray:
    """Complex factor by which the surroundings of each vertex turn and grow from x to y, in the axes of each map."""
    # each edge once from either side, but at a boundary
    start, end = f.T.ravel(), f.T[[1, 2, 0]].ravel()
    p, q = (
        np.einsum(
            "aie,ie->ae", at.take(start, axis=2), (z.take(end, axis=0) - z.take(start, axis=0)).T
        )
        for z, at in ((x, axes), (y, other))
    )
    n = len(x)
    weight = np.bincount(start, p[0] * p[0] + p[1] * p[1], n)
    real, imag = (
        np.bincount(start, part, n)
        for part in (p[0] * q[0] + p[1] * q[1], p[0] * q[1] - p[1] * q[0])
    )
    return np.asarray((real + 1j * imag) / np.where(weight > 0, weight, 1.0))
