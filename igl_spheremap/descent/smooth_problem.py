"""Descent along smooth fields: in an H2 metric a pull at one vertex moves its surroundings."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..mesh.check import Mesh
from ..mesh.measure import face_areas
from ..operators.factor import Factor, factorize
from ..sphere.rows import tangent
from .problem import Energy, HarmonicEnergy, Problem, SumEnergy, harmonic_problem

FloatArray = NDArray[np.float64]

#: Smallest image area of a vertex, in units of the mean, that the metric divides by.
_LEAST_AREA = 1e-6


@dataclass(frozen=True, eq=False)
class SmoothProblem(Problem):
    """A problem whose gradient is taken in the metric K = P B^-1 P with P = L + B.

    B holds image areas, so that a spherical harmonic of degree l has the eigenvalue (l (l + 1) + 1)^2
    whatever the source: fields of finite length are continuous, and a penalty at single vertices has a
    gradient that does not fold their neighbourhood.

    Attributes
    ----------
    P : (n, n) sparse matrix
        L + B.
    factor : Factor
        Its inverse.
    B : (n,) float64 array
        Image areas of the vertices, positive.
    """

    P: sp.csr_matrix = field(kw_only=True)
    factor: Factor = field(kw_only=True)
    B: FloatArray = field(kw_only=True)

    def evaluate(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Energy, and its gradient in the metric K, tangent to the sphere.

        Parameters
        ----------
        x : (n, 3) float64 array
            The map, unit rows.

        Returns
        -------
        energy : float
        gradient : (n, 3) float64 array
        """
        energy, derivative = self.energy.evaluate(x)
        h = self.factor.solve(tangent(x, derivative))
        return energy, tangent(x, self.factor.solve(self.B[:, None] * h))

    def inner(self, a: FloatArray, b: FloatArray) -> float:
        """Inner product by K.

        Parameters
        ----------
        a, b : (n, 3) float64 array
            Vector fields.

        Returns
        -------
        float
        """
        return float(np.vdot(self.P @ a, (self.P @ b) / self.B[:, None]))


def smooth_problem(mesh: Mesh, energies: tuple[Energy, ...], x: FloatArray) -> SmoothProblem:
    """The harmonic energy of a mesh and further terms, in the metric that a map makes.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    energies : tuple of Energy
        What is added to the harmonic energy; they must fix the Moebius gauge.
    x : (n, 3) float64 array
        The map whose image areas enter the metric, usually the start.

    Returns
    -------
    SmoothProblem
        Not gauge-fixed.

    Raises
    ------
    FactorisationFailed
        If the Laplacian is not positive definite in floating point.
    """
    harmonic = harmonic_problem(mesh)
    assert isinstance(harmonic.energy, HarmonicEnergy)
    B = np.bincount(mesh.f.ravel(), np.repeat(face_areas(x, mesh.f) / 3, 3))
    B = np.maximum(B, _LEAST_AREA * B.mean())
    P = (harmonic.energy.L + sp.diags(B)).tocsr()
    total = SumEnergy((harmonic.energy, *energies))
    return SmoothProblem(total, harmonic.A, gauge=False, P=P, factor=factorize(P), B=B)
