"""Energies of maps to the sphere: harmonic, p-harmonic, of landmarks, of users, and sums of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import igl
import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from ..gate import takes_mesh
from ..mesh.arrays import FloatArray, IntArray, check_rows, count, examples
from ..mesh.check import Mesh, check_mesh
from ..operators.laplacian import (
    Weights,
    apply_laplacian,
    is_usable,
    laplacian,
    laplacian_and_notes,
    mollified_edge_lengths,
)
from ..sphere.rows import inner, row_dots


class Energy(Protocol):
    """A differentiable function of the map."""

    def evaluate(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Value at `x` and the (n, 3) array of its derivatives by the coordinates."""


@dataclass(frozen=True, eq=False)
class HarmonicEnergy:
    """The harmonic (Dirichlet) energy: half the sum of x_k . L x_k over the three coordinates."""

    L: sp.csr_matrix

    @classmethod
    def of(cls, mesh: Mesh, weights: Weights = "cotangent") -> HarmonicEnergy:
        """The energy of a mesh; unusable weights are mollified."""
        return cls(laplacian_and_notes(mesh, weights)[0])

    def evaluate(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Value and derivatives, L x."""
        gradient = apply_laplacian(self.L, x)
        return 0.5 * inner(x, gradient), gradient  # eq. (6)


@takes_mesh
def harmonic_energy(v: ArrayLike, f: ArrayLike, x: ArrayLike) -> float:
    """Harmonic energy of a map, equation (6).

    Parameters
    ----------
    v, f, x
        As of `angle_differences`; the scale of `v` changes nothing.

    Returns
    -------
    float
        4 pi for a smooth conformal map; at least the flat area of the image, with equality for faces that keep their
        angles.

    Raises
    ------
    MeshError
        If `v, f` is not a closed genus-0 mesh or `x` has not one row per vertex.

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
    return HarmonicEnergy.of(mesh).evaluate(check_rows(x, len(mesh.v), "images"))[0]


@dataclass(frozen=True, eq=False)
class PHarmonicEnergy:
    """The integral of ``|grad F|^p / p`` over the source, for a map that is linear on each face."""

    #: Exponent above 1; 2 gives the harmonic energy.
    p: float
    #: (3 m, n), takes positions to the vectors along the side opposite each corner.
    sides: sp.csr_matrix
    #: (m, 3), of the source's corners.
    half_cotangents: FloatArray
    #: (m,), of the source's faces, positive.
    areas: FloatArray

    @classmethod
    def of(cls, mesh: Mesh, p: float) -> PHarmonicEnergy:
        """The energy of a mesh; unusable lengths are mollified. Unless p is above 1, a ValueError."""
        if not 1 < p < np.inf:
            raise ValueError(
                f"p = {p:g} is out of range: the p-harmonic energy needs a finite p above 1"
            )
        n, m = len(mesh.v), len(mesh.f)
        if is_usable(laplacian(mesh.unit, mesh.f, "cotangent", mesh.edges)):
            lengths = igl.edge_lengths(mesh.unit, mesh.f)
        else:
            lengths = mollified_edge_lengths(mesh.unit, mesh.f)
        rows = np.arange(3 * m)
        head, tail = np.roll(mesh.f, -1, axis=1).ravel(), np.roll(mesh.f, -2, axis=1).ravel()
        ones = np.ones(3 * m)
        sides = sp.csr_matrix(
            (np.r_[ones, -ones], (np.r_[rows, rows], np.r_[head, tail])), shape=(3 * m, n)
        )
        areas = np.asarray(igl.doublearea(l=lengths, nan_replacement=0.0)).ravel() / 2
        return cls(p, sides, np.asarray(igl.cotmatrix_entries(lengths)), areas)

    def evaluate(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Value and derivatives: those of the harmonic energy with each face weighted by |grad F|^(p - 2)."""
        side = self.sides @ x
        square = row_dots(side, side).reshape(-1, 3)
        density = np.maximum(row_dots(self.half_cotangents, square) / self.areas, 0.0)  # eq. (5)
        value = float(np.einsum("i,i->", self.areas, density ** (self.p / 2))) / self.p  # eq. (8)
        # If the map is constant, the gradient vanishes for every p > 1, though the weight may be infinite.
        weight = np.power(density, self.p / 2 - 1, out=np.zeros_like(density), where=density > 0)
        side *= (weight[:, None] * self.half_cotangents).reshape(-1, 1)
        return value, self.sides.T @ side


@takes_mesh
def p_harmonic_energy(v: ArrayLike, f: ArrayLike, x: ArrayLike, p: float) -> float:
    """p-harmonic energy of a map, equation (8).

    Parameters
    ----------
    v, f, x
        As of `angle_differences`; the source counts as having unit area, for the energy depends on its scale unless p
        is 2.
    p : float
        Exponent, above 1.

    Returns
    -------
    float
        At p = 2, the harmonic energy.

    Raises
    ------
    MeshError
        As of `harmonic_energy`.
    ValueError
        If p is not above 1.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> from igl_spheremap.descent.energies import p_harmonic_energy
    >>> v, f = ism.samples.make("sphere", n_vertices=600)
    >>> round(p_harmonic_energy(v, f, v, 2) / ism.harmonic_energy(v, f, v), 12)
    1.0
    """
    mesh = check_mesh(v, f)
    return PHarmonicEnergy.of(mesh, p).evaluate(check_rows(x, len(mesh.v), "images"))[0]


@dataclass(frozen=True, eq=False)
class LandmarkEnergy:
    """Half the weighted sum of the squared chords between landmarks and their targets, which are unit rows."""

    vertices: IntArray
    targets: FloatArray
    weights: FloatArray

    def evaluate(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Value and derivatives, which are zero but at landmarks."""
        off = x[self.vertices] - self.targets
        gradient = np.zeros_like(x)
        np.add.at(gradient, self.vertices, self.weights[:, None] * off)
        return 0.5 * float(self.weights @ row_dots(off, off)), gradient


@dataclass(frozen=True, eq=False)
class OwnEnergy:
    """A user's function of a map that returns value and derivatives; errors name faults of these."""

    function: Callable[[FloatArray], tuple[float, ArrayLike]]

    def evaluate(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Value and derivatives, checked; the function can't change the map."""
        given = x.view()
        given.flags.writeable = False
        found = self.function(given)
        pair = isinstance(found, tuple | list) and len(found) == 2
        if not pair or np.ndim(found[0]) != 0 or np.asarray(found[0]).dtype.kind not in "iuf":
            raise TypeError(
                f"the fidelity term did not return a number and an array; return its value and its "
                f"({len(x)}, 3) derivatives"
            )
        value, derivatives = (
            float(found[0]),
            check_rows(found[1], len(x), "derivatives of the fidelity term"),
        )
        if np.isfinite(value) and not np.isfinite(derivatives).all():
            bad = np.flatnonzero(~np.isfinite(derivatives).all(axis=1))
            where = f"{count(bad, 'vertex', 'vertices')}, {examples(bad)}"
            raise ValueError(
                f"derivatives of the fidelity term are not finite at {where}; return finite ones, or an "
                "infinite value"
            )
        return value, derivatives


@dataclass(frozen=True, eq=False)
class SumEnergy:
    """The sum of several energies, each of which contains its weight."""

    terms: tuple[Energy, ...]

    def evaluate(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Sum of the values and of the derivatives."""
        values, gradients = zip(*(term.evaluate(x) for term in self.terms), strict=True)
        return float(sum(values)), np.sum(gradients, axis=0)
