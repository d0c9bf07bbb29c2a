"""Problems of first-order solvers: an energy over the maps of a mesh, in a metric, in the Moebius gauge or in none."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from ..mesh.arrays import TINY, FloatArray, IntArray
from ..mesh.check import Mesh, normalised_weights
from ..mesh.measure import vertex_areas
from ..operators.factor.factorize import Factor, factorize
from ..sphere.moebius import center
from ..sphere.rows import along, inner, row_dots, tangent, weighted_moment, weighted_sum
from .energies import Energy, PHarmonicEnergy


class Metric(ABC):
    """A metric on the vector fields along a map, in which an energy's gradient is its steepest direction.

    It is a symmetric positive definite operator K, which acts on each coordinate of a field alike.
    """

    @abstractmethod
    def solve(self, covector: FloatArray) -> FloatArray:
        """The field K^-1 times a covector."""

    @abstractmethod
    def inner(self, a: FloatArray, b: FloatArray) -> float:
        """Inner product of two fields: the sum of a . K b."""

    @property
    def l2_ratio(self) -> FloatArray | None:
        """The factors (n,) by which a diagonal metric's gradient differs from that of L2; None if it does not."""
        return None

    def gradient(self, x: FloatArray, derivative: FloatArray) -> FloatArray:
        """Tangent field at `x` that is dual to an energy's derivatives."""
        return tangent(x, self.solve(tangent(x, derivative)))

    def residual(self, gradient: FloatArray) -> float:
        """Norm of a gradient, which ends runs."""
        return float(np.sqrt(self.inner(gradient, gradient)))


@dataclass(frozen=True, eq=False)
class Diagonal(Metric):
    """One positive weight a vertex; with vertex areas for weights, the L2 metric of the source."""

    weights: FloatArray
    #: Vertex areas, if runs are to end by the L2 norm.
    areas: FloatArray | None = None

    @cached_property
    def l2_ratio(self) -> FloatArray | None:
        """Areas over weights; None if this is the L2 metric itself."""
        if self.areas is None:
            return None
        return self.areas / self.weights

    def solve(self, covector: FloatArray) -> FloatArray:
        """Each row divided by its weight."""
        return covector / self.weights[:, None]

    def inner(self, a: FloatArray, b: FloatArray) -> float:
        """The weighted sum of a_i . b_i."""
        return float(np.einsum("i,i->", self.weights, row_dots(a, b)))  # eq. (13)

    def gradient(self, x: FloatArray, derivative: FloatArray) -> FloatArray:
        """A F of eq. (9); one projection is enough, since it commutes with a diagonal."""
        return tangent(x, self.solve(derivative))  # H = -Laplace-Beltrami F, eqs. (9), (13)

    def residual(self, gradient: FloatArray) -> float:
        """The L2 norm of A F, so that runs in all diagonal metrics with areas end by one rule."""
        return float(np.sqrt(self._l2.inner(gradient, gradient)))

    @cached_property
    def _l2(self) -> Diagonal:
        """The metric whose norm of a gradient is the L2 norm of A F; the metric itself if areas are not known."""
        if self.areas is None:
            return self
        return Diagonal(self.weights**2 / self.areas)


def l2_metric(mesh: Mesh) -> Diagonal:
    """The paper's metric: vertex areas by libigl's mass matrix."""
    shares = vertex_areas(mesh.unit, mesh.f)
    return Diagonal(normalised_weights(shares, float(shares.sum())))  # eq. (13)


def frobenius_metric(mesh: Mesh) -> Diagonal:
    """The metric of the authors' program (paper/optm.py), which divides derivatives by nothing."""
    return Diagonal(np.ones(len(mesh.v)))


def laplacian_metric(L: sp.csr_matrix, areas: FloatArray | None = None) -> Diagonal:
    """The diagonal metric that bounds a Laplacian from above, in which steps up to 1 are safe.

    The derivative of Gu and Yau is L x without division by areas: the weights of a Laplacian in the plane have no
    scale, so this metric is better conditioned for unevenly spread vertices. Each vertex is bounded by the sum of
    absolute values in its row; one step for all would be as small as the worst vertex demands.
    """
    bounds = np.asarray(abs(L).sum(axis=1)).ravel()
    return Diagonal(np.maximum(bounds, TINY), areas)


@dataclass(frozen=True, eq=False)
class SobolevH1(Metric):
    """P = L + tiny M, factorised: the harmonic energy's own Hessian, up to the sphere's curvature."""

    factor: Factor
    L: sp.csr_matrix

    def solve(self, covector: FloatArray) -> FloatArray:
        """P^-1 times a covector."""
        return self.factor.solve(covector)

    def inner(self, a: FloatArray, b: FloatArray) -> float:
        """The sum of a . L b, which is that of a . P b to nine digits."""
        return inner(a, self.L @ b)


@dataclass(frozen=True, eq=False)
class SobolevH2(Metric):
    """P B^-1 P with P = L + B, and B the image areas of the vertices.

    A spherical harmonic of degree l has the eigenvalue (l (l + 1) + 1)^2 on any source. So fields of finite length are
    continuous, and the gradient of a penalty at single vertices does not fold their neighbourhood.
    """

    factor: Factor
    P: sp.csr_matrix
    B: FloatArray

    @classmethod
    def of(
        cls, L: sp.csr_matrix, f: IntArray, x: FloatArray, least_area: float = 1e-6
    ) -> SobolevH2:
        """The metric that the map `x` makes; if P is not positive definite, a FactorisationFailed.

        No area is below `least_area` times the mean, since it is divided by, and vertices of limbs have next to none.
        """
        B = vertex_areas(x, f)
        B = np.maximum(B, least_area * B.mean())
        P = (L + sp.diags(B)).tocsr()
        return cls(factorize(P), P, B)

    def solve(self, covector: FloatArray) -> FloatArray:
        """P^-1 B P^-1 times a covector."""
        return self.factor.solve(self.B[:, None] * self.factor.solve(covector))

    def inner(self, a: FloatArray, b: FloatArray) -> float:
        """The sum of P a . B^-1 P b."""
        return inner(self.P @ a, (self.P @ b) / self.B[:, None])


@dataclass(frozen=True, eq=False)
class Problem:
    """An energy to minimise over the maps of a mesh, in a metric; a solver knows no more of the mesh."""

    energy: Energy
    #: The metric in which the gradient is taken.
    metric: Metric
    #: (n,) vertex areas of eq. (13), positive, of sum 1, which the Moebius gauge balances.
    A: FloatArray
    #: (m, 3) faces.
    f: IntArray
    #: True if the energy is the same for Moebius-equivalent maps, up to its discretisation error. Then boosts are kept
    #: out of the descent (see `remove_boosts`), and the map is kept centred.
    fixes_gauge: bool = True

    @classmethod
    def of(cls, mesh: Mesh, energy: Energy, metric: Metric, fixes_gauge: bool = True) -> Problem:
        """An energy over the maps of a mesh, in a metric."""
        return cls(energy, metric, mesh.A, mesh.f, fixes_gauge)

    def evaluate(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Energy and `gradient`."""
        energy, derivative = self.energy.evaluate(x)
        return energy, self.gradient(x, derivative)

    def gradient(self, x: FloatArray, derivative: FloatArray) -> FloatArray:
        """Gradient of the energy from its derivatives, tangent to the sphere, without boosts if the gauge is fixed."""
        gradient = self.metric.gradient(x, derivative)
        if not self.fixes_gauge:
            return gradient
        return remove_boosts(x, gradient, self.A, self.metric.l2_ratio)

    def centred(self, x: FloatArray, off: float = 0.0) -> FloatArray:
        """The map in the Moebius gauge; without a gauge, or with its mean at most `off` from the origin, `x` itself."""
        if self.fixes_gauge and np.linalg.norm(weighted_sum(self.A, x)) > off:
            return center(x, self.A)
        return x


def p_harmonic_problem(mesh: Mesh, p: float) -> Problem:
    """The p-harmonic energy of a mesh, in the L2 metric.

    Gauge-fixed for p up to 2: there crowding a map into a point lowers the energy (a bubble of size r has energy in
    proportion to r^(2 - p)). Above 2 it rises, and the energy keeps the map spread out by itself.
    """
    return Problem.of(mesh, PHarmonicEnergy.of(mesh, p), l2_metric(mesh), fixes_gauge=p <= 2)


def remove_boosts(
    x: FloatArray, t: FloatArray, weights: FloatArray, l2_ratio: FloatArray | None = None
) -> FloatArray:
    """Part of a tangent field that leaves the weighted mean of `x` in place: orthogonal to all boosts.

    Given the `l2_ratio` of a `Metric`, boosts are multiplied by it before they are taken out: then the result
    vanishes at the same maps as in the L2 metric.

    The chord energy of eq. (6) can always be lowered by Moebius maps that crowd the mesh into a point under one big
    triangle, so its minimisers are useless. The boosts ``e - (e . x) x`` lead there.

    >>> from igl_spheremap.sphere.rows import tangent
    >>> x = np.vstack((np.eye(3), -np.eye(3)))
    >>> boost = tangent(x, np.tile([1.0, 2.0, 3.0], (6, 1)))
    >>> bool(np.abs(remove_boosts(x, boost, np.ones(6))).max() < 1e-12)
    True
    """
    scaled = weights
    if l2_ratio is not None:
        scaled = weights * l2_ratio
    total = scaled.sum()
    gram = total * np.eye(3) - weighted_moment(scaled, x, x)  # inner products of the three boosts
    ridge = 1e-14 * total * np.eye(3)  # the sum is singular for a map to one point
    e = np.linalg.solve(gram + ridge, weighted_sum(weights, t))
    boost = along(x, e)[:, None] * x
    if l2_ratio is None:
        boost += t - e
    else:
        boost -= e
        boost *= l2_ratio[:, None]
        boost += t
    return boost
