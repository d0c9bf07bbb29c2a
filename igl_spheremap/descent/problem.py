"""What a solver minimises: an energy over maps of a mesh, in a metric, up to Moebius maps or not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..mesh.arrays import FloatArray, IntArray
from ..mesh.check import Mesh
from ..sphere.cayley import cayley_step
from ..sphere.moebius import center
from ..sphere.rows import along, weighted_moment, weighted_sum
from ..verify.signs import folded_faces
from .energies import Energy
from .energies.harmonic import HarmonicEnergy
from .energies.p_harmonic import PHarmonicEnergy
from .metrics import Diagonal, Metric

Trial = Callable[[float], tuple[float, tuple[FloatArray, FloatArray]]]


@dataclass(frozen=True, eq=False)
class Problem:
    """All that a solver has to know of the mesh; what else it takes are its own options."""

    energy: Energy
    #: In which the gradient is taken.
    metric: Metric
    #: (n,) vertex areas of eq. (13), positive, of sum 1: what the Moebius gauge balances.
    A: FloatArray
    #: (m, 3) faces.
    f: IntArray
    #: True if the energy is the same for Moebius-equivalent maps, but for its discretisation error: boosts are kept out
    #: of the descent then (see `remove_boosts`), and the map is kept centred.
    gauge: bool = True

    @classmethod
    def of(cls, mesh: Mesh, energy: Energy, metric: Metric | None = None, gauge: bool = True) -> Problem:
        """An energy over the maps of a mesh, in the L2 metric unless another is given."""
        A = mesh.A
        return cls(energy, Diagonal(A) if metric is None else metric, A, mesh.f, gauge)

    def evaluate(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Energy and `gradient`."""
        energy, derivative = self.energy.evaluate(x)
        return energy, self.gradient(x, derivative)

    def gradient(self, x: FloatArray, derivative: FloatArray) -> FloatArray:
        """Gradient of the energy from its derivatives, tangent to the sphere, without boosts if the gauge is fixed."""
        gradient = self.metric.gradient(x, derivative)
        return remove_boosts(x, gradient, self.A) if self.gauge else gradient

    def inner(self, a: FloatArray, b: FloatArray) -> float:
        """Inner product of two fields in the metric."""
        return self.metric.inner(a, b)

    def centred(self, x: FloatArray, off: float = 0.0) -> FloatArray:
        """The map in the Moebius gauge; `x` itself where there is none or its mean is at most `off` from the origin."""
        return center(x, self.A) if self.gauge and np.linalg.norm(weighted_sum(self.A, x)) > off else x

    def cayley_path(self, x: FloatArray, h: FloatArray, off: float, injective: bool = False) -> Trial:
        """What a line search tries: Cayley updates of `x` by `h`, centred where they are more than `off` away.

        A trial returns the energy, infinite where an `injective` map folds; and the map and the derivatives there.
        """
        def trial(tau: float) -> tuple[float, tuple[FloatArray, FloatArray]]:
            y = self.centred(cayley_step(x, h, tau), off)  # Theorem 1
            if injective and not self.is_injective(y):
                return np.inf, (y, h)
            energy, derivative = self.energy.evaluate(y)
            return energy, (y, derivative)

        return trial

    def is_injective(self, x: FloatArray) -> bool:
        """True if no face of the map is flipped or degenerate."""
        return not folded_faces(x, self.f).any()


def harmonic_problem(mesh: Mesh) -> Problem:
    """The harmonic energy of a mesh, in the L2 metric."""
    return Problem.of(mesh, HarmonicEnergy.of(mesh))


def p_harmonic_problem(mesh: Mesh, p: float) -> Problem:
    """The p-harmonic energy of a mesh, in the L2 metric.

    Gauge-fixed for p up to 2: there the energy falls when a map is crowded into a point (a bubble of size r has
    r^(2 - p) of it). Above 2 it rises, and the energy keeps the map spread out by itself.
    """
    return Problem.of(mesh, PHarmonicEnergy.of(mesh, p), gauge=p <= 2)


def remove_boosts(x: FloatArray, t: FloatArray, weights: FloatArray) -> FloatArray:
    """Part of a tangent field that leaves the weighted mean of `x` in place: orthogonal to all boosts.

    The chord energy of eq. (6) can always be lowered by Moebius maps that crowd the mesh into a point under one big
    triangle, so that its minimisers are useless; the boosts ``e - (e . x) x`` are the directions that lead there.

    >>> from igl_spheremap.sphere.rows import tangent
    >>> x = np.vstack((np.eye(3), -np.eye(3)))
    >>> boost = tangent(x, np.tile([1.0, 2.0, 3.0], (6, 1)))
    >>> bool(np.abs(remove_boosts(x, boost, np.ones(6))).max() < 1e-12)
    True
    """
    total = weights.sum()
    gram = total * np.eye(3) - weighted_moment(weights, x, x)  # inner products of the three boosts
    e = np.linalg.solve(gram + 1e-14 * total * np.eye(3), weighted_sum(weights, t))
    return t - e + along(x, e)[:, None] * x
