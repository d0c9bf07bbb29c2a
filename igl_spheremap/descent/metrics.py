"""Metrics on the vector fields along a map: an energy's gradient is its steepest direction in one of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ..mesh.arrays import FloatArray, IntArray
from ..mesh.measure import vertex_areas
from ..operators.factor.factorize import Factor, factorize
from ..sphere.rows import inner, row_dots, tangent

#: Relative accuracy of P^-1 where the factor is only approximate: enough for a direction of descent.
_ACCURACY = 0.1
#: Smallest image area of a vertex, in units of the mean, that the H2 metric divides by.
_LEAST_AREA = 1e-6


class Metric(ABC):
    """A symmetric positive definite operator K, which acts on each coordinate of a field alike."""

    @abstractmethod
    def solve(self, covector: FloatArray) -> FloatArray:
        """The field K^-1 times a covector."""

    @abstractmethod
    def inner(self, a: FloatArray, b: FloatArray) -> float:
        """Inner product of two fields: the sum of a . K b."""

    def gradient(self, x: FloatArray, derivative: FloatArray) -> FloatArray:
        """Tangent field at `x` that is dual to an energy's derivatives."""
        return tangent(x, self.solve(tangent(x, derivative)))


@dataclass(frozen=True, eq=False)
class Diagonal(Metric):
    """One positive weight a vertex; with vertex areas for weights, the L2 metric of the source."""

    weights: FloatArray

    def solve(self, covector: FloatArray) -> FloatArray:
        """Each row divided by its weight."""
        return covector / self.weights[:, None]

    def inner(self, a: FloatArray, b: FloatArray) -> float:
        """The weighted sum of a_i . b_i."""
        return float(np.einsum("i,i->", self.weights, row_dots(a, b)))  # eq. (13)

    def gradient(self, x: FloatArray, derivative: FloatArray) -> FloatArray:
        """A F of eq. (9); one projection is enough, for it commutes with a diagonal."""
        return tangent(x, self.solve(derivative))  # H = -Laplace-Beltrami F, eqs. (9), (13)


@dataclass(frozen=True, eq=False)
class SobolevH1(Metric):
    """P = L + tiny M, factorised: the harmonic energy's own Hessian, but for the sphere's curvature."""

    factor: Factor
    L: sp.csr_matrix

    def solve(self, covector: FloatArray) -> FloatArray:
        """P^-1 times a covector, to a tenth where the factor is only approximate."""
        return self.factor.solve(covector, _ACCURACY)

    def inner(self, a: FloatArray, b: FloatArray) -> float:
        """The sum of a . L b, which is that of a . P b to nine digits."""
        return inner(a, self.L @ b)


@dataclass(frozen=True, eq=False)
class SobolevH2(Metric):
    """P B^-1 P with P = L + B, and B the image areas of the vertices.

    A spherical harmonic of degree l has the eigenvalue (l (l + 1) + 1)^2 whatever the source: fields of finite length
    are continuous, and a penalty at single vertices has a gradient that does not fold their neighbourhood.
    """

    factor: Factor
    P: sp.csr_matrix
    B: FloatArray

    @classmethod
    def of(cls, L: sp.csr_matrix, f: IntArray, x: FloatArray) -> SobolevH2:
        """The metric that the map `x` makes; a FactorisationFailed where P is not positive definite."""
        B = vertex_areas(x, f)
        B = np.maximum(B, _LEAST_AREA * B.mean())
        P = (L + sp.diags(B)).tocsr()
        return cls(factorize(P), P, B)

    def solve(self, covector: FloatArray) -> FloatArray:
        """P^-1 B P^-1 times a covector."""
        return self.factor.solve(self.B[:, None] * self.factor.solve(covector))

    def inner(self, a: FloatArray, b: FloatArray) -> float:
        """The sum of P a . B^-1 P b."""
        return inner(self.P @ a, (self.P @ b) / self.B[:, None])
