"""One damped loop of Newton steps over maps: a problem is minimised, a damping shortens the steps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import numpy as np

from ..errors import FactorisationFailed
from ..mesh.arrays import ROUNDING, BoolArray, FloatArray
from ..mesh.edges import marked, touching
from ..operators.factor.factor import Factor
from .system import VertexSystem

#: Damping with which most of Levenberg's steps succeed; on maps of deep limbs less of it folds hundreds of faces.
DAMPED = 3e-4
#: Largest number of conditions on a step: each costs a solve, and these solves cost as much as a factorisation.
CONDITIONS = 16


@dataclass(frozen=True, eq=False)
class Model:
    """A quadratic model of a problem at a map.

    Attributes
    ----------
    value : float
        Value of the problem there.
    axes : (2, d, n) float64 array
        The two directions in which each vertex moves; unknowns are steps along them.
    gradient : (2, n) float64 array
        First derivatives.
    blocks : (6, 2, 2, m) float64 array
        Faces' parts of a positive semidefinite Hessian, for the corner pairs of `newton.system.PAIRS`.
    at_vertices : (2, 2, n) float64 array, optional
        Vertices' parts of it.
    border : ((k, 2, n), (k,)) float64 arrays, optional
        Linear conditions C s = c on the step s.
    """

    value: float
    axes: FloatArray
    gradient: FloatArray
    blocks: FloatArray
    at_vertices: FloatArray | None = None
    border: tuple[FloatArray, FloatArray] | None = None


class Trial(NamedTuple):
    """Outcome of a step: a map without new foldings, its value, and the faces that the step itself would fold.

    Without such a map the value is infinite. Each row (2, n) of `apart` is of two parts that the step brings together:
    its product with a step is the speed at which they move apart. If none is negative, a step may get farther.
    """

    x: FloatArray
    value: float
    folded: BoolArray
    apart: FloatArray | None = None


class NewtonProblem(Protocol):
    """A function of maps to minimise, and the maps that its steps may reach."""

    def model(self, x: FloatArray) -> Model:
        """Value, gradient and Hessian at a map."""

    def move(self, x: FloatArray, model: Model, step: FloatArray) -> FloatArray:
        """Displacements (n, d) of a step (2, n) along the model's axes."""

    def accept(self, x: FloatArray, move: FloatArray) -> Trial:
        """The map that a move leads to; its signs are exact."""


class Damping(Protocol):
    """A search for a step that lowers a problem's value."""

    def step(self, problem: NewtonProblem, x: FloatArray, model: Model) -> Trial | None:
        """The next map; None if none is found."""


def newton(problem: NewtonProblem, damping: Damping, x: FloatArray) -> Iterator[Trial]:
    """Steps from a map without foldings, each of lower value, until no step lowers it."""
    while (trial := damping.step(problem, x, problem.model(x))) is not None:
        x = trial.x
        yield trial


class LineSearch:
    """Newton steps, halved until they lower the value; the next one is tried at twice the length of the last.

    If parts would meet, the step is first solved again under the condition that these keep their distance.

    Attributes
    ----------
    length : float
        Share of Newton's step that the last one took.
    predicted : float
        Decrease of the value by the last whole step, were it quadratic.
    """

    #: Share of the diagonal that is added to it: rotations of the sphere cost nothing.
    damping = 1e-8
    #: Share of the predicted decrease that a step must bring (Armijo), as rho in Algorithm 1.
    rho = 1e-4
    #: Share of Newton's step below which the search gives up: shorter steps gain next to nothing.
    shortest = 1e-3

    def __init__(self, system: VertexSystem) -> None:
        self.system, self.length, self.predicted = system, 1.0, np.inf

    def step(self, problem: NewtonProblem, x: FloatArray, model: Model) -> Trial | None:
        """The first of ever shorter steps that lowers the value enough."""
        values = self.system.assemble(model.blocks, model.at_vertices)
        try:
            factor = self.system.factorize(self.system.damped(values, self.damping))
        except FactorisationFailed:
            return None
        return self.search(problem, x, model, factor)

    def search(
        self, problem: NewtonProblem, x: FloatArray, model: Model, factor: Factor
    ) -> Trial | None:
        """The first of ever shorter steps that lowers the value enough, given a factor of the model's Hessian."""
        self.length = min(1.0, 2 * self.length)
        held: Model | None = model  # each model is solved once, for all lengths of its step
        while self.length >= self.shortest:
            if held is not None:
                model, step = held, bordered_step(self.system, factor, held)
                slope, move = float((model.gradient * step).sum()), problem.move(x, model, step)
                self.predicted = -slope / 2
            trial = problem.accept(x, self.length * move)
            if model.value - trial.value > -self.length * self.rho * slope:
                return trial
            held = _held_apart(model, trial, step)
            if held is None:
                self.length /= 2
        return None


class Levenberg:
    """Damped Gauss-Newton steps; each vertex has a damping, which grows around faces that a step folds.

    Attributes
    ----------
    damping : (n,) float64 array
        Share of the Hessian's diagonal that is added at each vertex.
    systems : int
        Number of systems that may still be solved.
    at_once : bool
        Whether the last step kept its first damping, so that its gain predicts the next.
    """

    #: The damping is multiplied by this around faces that a step folds.
    raised_around = 10.0
    #: The damping of all vertices is multiplied by this after a step that failed.
    raised_everywhere = 4.0
    #: The damping of all vertices is multiplied by this after a step that succeeds at once.
    lowered = 0.1
    #: A vertex of larger damping moves by less than a tenth of its undamped step: there the search gives up.
    largest = 10.0

    def __init__(self, system: VertexSystem, damping: FloatArray, systems: int) -> None:
        self.system, self.damping, self.systems, self.at_once = system, damping, systems, True

    def step(self, problem: NewtonProblem, x: FloatArray, model: Model) -> Trial | None:
        """The first of ever more damped steps that lowers the value."""
        values, self.at_once = self.system.assemble(model.blocks, model.at_vertices), True
        failed = (0, 0.0)  # number of faces that the last step folded, and its value
        while self.systems > 0:
            self.systems -= 1
            try:
                # without the last number a vertex whose faces have no weight is singular
                damped = self.system.damped(values, self.damping, ROUNDING)
                factor = self.system.factorize(damped, within_memory=True)
            except FactorisationFailed:
                return None
            trial = problem.accept(
                x, problem.move(x, model, bordered_step(self.system, factor, model))
            )
            self._grow(trial.folded)
            if trial.value < model.value:
                if self.at_once:
                    self.damping *= self.lowered
                return trial
            many = int(trial.folded.sum())
            if self.damping.min() >= self.largest or (
                many >= failed[0] > 0 and failed[1] <= trial.value < np.inf
            ):
                return None  # more damping helps no more
            failed = many, trial.value
            self.damping, self.at_once = (
                np.maximum(self.raised_everywhere * self.damping, DAMPED),
                False,
            )
        return None

    def _grow(self, folded: BoolArray) -> None:
        """Damp the vertices around folded faces, and their neighbours."""
        f = self.system.f
        around = marked(f[folded], self.system.n)
        around[f[touching(f, around)]] = True
        self.damping = np.minimum(
            self.largest, np.where(around, self.raised_around, 1) * self.damping
        )


def _held_apart(model: Model, trial: Trial, step: FloatArray, still: float = 1e-9) -> Model | None:
    """The model under the condition that parts which a step brings together keep their distance; None if none come.

    Parts keep it, but for rounding, if they come nearer by less than the share `still` of the largest move.
    """
    if trial.apart is None:
        return None
    nearing = np.einsum("kan,an->k", trial.apart, step) < -still * np.abs(step).max()
    C = trial.apart[nearing]
    if model.border is not None:
        C = np.concatenate((model.border[0], C))
    if not nearing.any() or len(C) > CONDITIONS:
        return None
    return replace(model, border=(C, np.zeros(len(C))))


def bordered_step(system: VertexSystem, factor: Factor, model: Model) -> FloatArray:
    """Newton's step (2, n) under the model's conditions.

    ::

        [H  C^T] [s]   [-g]        s = -H^-1 (g + C^T m)
        [C   0 ] [m] = [ c]        C H^-1 C^T m = -(c + C H^-1 g)
    """
    if model.border is None:
        return -system.solve(factor, model.gradient)
    C, c = model.border
    free, *columns = system.solve(factor, np.concatenate((model.gradient[None], C)))
    HC = np.stack(columns)
    m = np.linalg.lstsq(
        np.einsum("ian,jan->ij", C, HC), -(c + np.einsum("ian,an->i", C, free)), rcond=None
    )[0]
    return np.asarray(-free - np.einsum("i,ian->an", m, HC))
