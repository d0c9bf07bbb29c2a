"""Energies of a map to the sphere: each gives its value and gradient in one evaluation, and they add up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from ..mesh.check import Mesh, check_mesh, check_rows
from ..operators.laplacian import positive_areas, usable_laplacian
from ..sphere.rows import along, inner, row_dots, tangent, weighted_moment, weighted_sum

FloatArray = NDArray[np.float64]



class Energy(Protocol):
    """A differentiable function of the map."""

    def evaluate(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Value at `x` and the (n, 3) array of its derivatives by the coordinates."""
        ...


@dataclass(frozen=True, eq=False)
class HarmonicEnergy:
    """The harmonic (Dirichlet) energy of eq. (6): half the sum of x_k . L x_k over the three coordinates.

    Attributes
    ----------
    L : (n, n) sparse matrix
        Positive semidefinite Laplacian.
    """

    L: sp.csr_matrix

    def evaluate(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Value and derivatives.

        Parameters
        ----------
        x : (n, 3) float64 array
            The map.

        Returns
        -------
        energy : float
            4 pi for a smooth conformal map; slightly less on a mesh, whose image is inscribed.
        gradient : (n, 3) float64 array
            L x.
        """
        gradient = self.L @ x
        return 0.5 * inner(x, gradient), gradient  # eq. (6)


@dataclass(frozen=True, eq=False)
class SumEnergy:
    """Energies added up, each with its own weight inside it.

    Attributes
    ----------
    terms : tuple of Energy
        The summands.
    """

    terms: tuple[Energy, ...]

    def evaluate(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Sum of the values and of the derivatives.

        Parameters
        ----------
        x : (n, 3) float64 array
            The map.

        Returns
        -------
        energy : float
        gradient : (n, 3) float64 array
        """
        values, gradients = zip(*(term.evaluate(x) for term in self.terms), strict=True)
        return float(sum(values)), np.sum(gradients, axis=0)


@dataclass(frozen=True, eq=False)
class Problem:
    """What a solver minimises: an energy, the L2 metric of the source, and whether the Moebius gauge is fixed.

    Attributes
    ----------
    energy : Energy
        The objective.
    A : (n,) float64 array
        Vertex areas of eq. (13), bounded away from zero, for the L2 inner product.
    gauge : bool
        True if the energy does not tell Moebius-equivalent maps apart but for its discretisation error, so that
        boosts must be kept out of the descent (see `remove_boosts`).
    """

    energy: Energy
    A: FloatArray
    gauge: bool = True

    def evaluate(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Energy, and its gradient A F in the L2 metric, tangent to the sphere.

        Parameters
        ----------
        x : (n, 3) float64 array
            The map, unit rows.

        Returns
        -------
        energy : float
        gradient : (n, 3) float64 array
            A F of eq. (9), without boosts if `gauge`.
        """
        energy, derivative = self.energy.evaluate(x)
        gradient = tangent(x, derivative / self.A[:, None])  # H = -Laplace-Beltrami F, eqs. (9), (13)
        return energy, remove_boosts(x, gradient, self.A) if self.gauge else gradient

    def inner(self, a: FloatArray, b: FloatArray) -> float:
        """L2 inner product by eq. (13).

        Parameters
        ----------
        a, b : (n, 3) float64 array
            Vector fields.

        Returns
        -------
        float
            The sum of A_i a_i . b_i.
        """
        return float(np.einsum("i,i->", self.A, row_dots(a, b)))  # eq. (13)


def harmonic_problem(mesh: Mesh) -> Problem:
    """The harmonic energy of a mesh, with mollified weights where its own are unusable.

    Parameters
    ----------
    mesh : Mesh
        The checked source.

    Returns
    -------
    Problem
        Gauge-fixed.
    """
    return Problem(HarmonicEnergy(usable_laplacian(mesh.v, mesh.f)), positive_areas(mesh))


def remove_boosts(x: FloatArray, t: FloatArray, weights: FloatArray) -> FloatArray:
    """Part of a tangent field that moves the weighted mean of `x` not at all: orthogonal to all boosts.

    The chord energy of eq. (6) can always be lowered by Moebius maps that crowd the mesh into a point under one big
    triangle, so that its minimisers are useless; the boosts ``e - (e . x) x`` are the directions that lead there.

    Parameters
    ----------
    x : (n, 3) float64 array
        Unit rows.
    t : (n, 3) float64 array
        Tangent field at `x`.
    weights : (n,) float64 array
        Weights of the inner product.

    Returns
    -------
    (n, 3) float64 array
        Tangent field whose weighted sum is zero.

    Examples
    --------
    >>> import numpy as np
    >>> x = np.vstack((np.eye(3), -np.eye(3)))
    >>> boost = tangent(x, np.tile([1.0, 2.0, 3.0], (6, 1)))
    >>> bool(np.abs(remove_boosts(x, boost, np.ones(6))).max() < 1e-12)
    True
    """
    total = weights.sum()
    gram = total * np.eye(3) - weighted_moment(weights, x, x)  # inner products of the three boosts
    e = np.linalg.solve(gram + 1e-14 * total * np.eye(3), weighted_sum(weights, t))
    return t - e + along(x, e)[:, None] * x


def harmonic_energy(v: ArrayLike, f: ArrayLike, x: ArrayLike) -> float:
    """Harmonic energy of a map, eq. (6).

    Parameters
    ----------
    v : (n, 3) array_like
        Source positions; the energy does not depend on their scale.
    f : (m, 3) array_like
        Faces as 0-based vertex indices.
    x : (n, 3) array_like
        Images of the vertices.

    Returns
    -------
    float
        4 pi for a smooth conformal map; at least the flat area of the image, with equality face by face where
        angles are kept.

    Raises
    ------
    MeshError
        If `v, f` is no closed genus-0 mesh or `x` has not one row per vertex.

    References
    ----------
    Lai et al., eq. (6).

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> x = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]]
    >>> f = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    >>> round(ism.harmonic_energy(x, f, x) - 4 * 3**0.5, 12)  # the area, for the identity
    0.0
    """
    mesh = check_mesh(v, f)
    x = check_rows(x, len(mesh.v), "images")
    return harmonic_problem(mesh).energy.evaluate(x)[0]
