"""Preconditioned Cayley steps of length one: the paper's update with H replaced by P^-1 H."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from itertools import count

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..mesh.measure import face_areas
from ..operators.factor import Factor, refined_solve
from ..sphere.cayley import cayley_update
from ..sphere.moebius import center
from ..sphere.rows import along, inner, row_dots, weighted_moment, weighted_sum
from .iterate import Iterate
from .line_search import NonmonotoneSearch

FloatArray = NDArray[np.float64]

#: The weighted mean of the map may be this far from the origin before the Moebius gauge is restored.
_OFF_CENTRE = 1e-4
#: Of the steps, where the factor is only approximate.
_ACCURACY = 0.1
#: Rise of the energy, as a share of it, that is rounding.
_ROUNDING = 1e-13
#: With contraction 1/3 for the lowest mode, l = 2, the energy left after a step is g.D / 12; measured, it is less.
_LEFT = 18.0
#: Bounds the gap between energy and area from below, where a mesh is conformal to rounding (a tetrahedron).
_LEAST_GAP = 1e-9


@dataclass(frozen=True, eq=False)
class SobolevCayley:
    """Steps in the metric P = L + tiny M, in which the harmonic map's Hessian has condition number 1.5.

    Beyond the Moebius gauge its eigenvalues on the sphere are (l (l + 1) - 2) / (l (l + 1)) for l >= 2, between 2/3
    and 1, so that a step of length one gains a factor of three at the least. The search of Algorithm 1 shortens it only
    where bad triangles make the energy rise.

    Parameters
    ----------
    L : (n, n) sparse matrix
        Laplacian.
    P : (n, n) sparse matrix
        L + tiny M.
    factor : Factor
        Applies P^-1; refined by conjugate gradients where it is only approximate.
    A : (n,) float64 array
        Vertex areas, which the gauge balances.
    f : (m, 3) int64 array
        Faces, for the flat image area.
    """

    L: sp.csr_matrix
    P: sp.csr_matrix
    factor: Factor
    A: FloatArray
    f: NDArray[np.int64]

    def iterates(self, x: FloatArray) -> Iterator[Iterate]:
        """Yield the start and every iterate after it.

        Parameters
        ----------
        x : (n, 3) float64 array
            Start, unit rows.

        Yields
        ------
        Iterate
            Its residual is the energy that is estimated to be left above the minimum, in units of the gap between
            energy and flat image area, which is the mesh's own discretisation error; infinite for the start.
        """
        x, H, density, energy = self._evaluate(x)
        yield Iterate("sobolev", 0, 0, x, energy, np.inf)
        for k in count(1):
            g = H - density[:, None] * x  # eq. (9)
            e = _boost(x, g, density)
            g += density[:, None] * (along(x, e)[:, None] * x - e)
            D = refined_solve(self.P, self.factor, g, _ACCURACY)
            D -= weighted_sum(self.A, D) / self.A.sum()
            left = inner(g, D) / _LEFT
            search = NonmonotoneSearch(energy * (1 + _ROUNDING), delta=0.5)
            step = search.search(partial(self._along, x, D), 1.0, -inner(g, D))  # Algorithm 1, step 3
            if step is None:
                return
            x, H, density = step.trial
            energy = step.energy
            gap = energy - float(face_areas(x, self.f).sum())
            yield Iterate("sobolev", 0, k, x, energy, left / max(gap, _LEAST_GAP), step.tau)

    def _along(self, x: FloatArray, D: FloatArray, tau: float) -> tuple[float, tuple[FloatArray, ...]]:
        """Energy after a step, and what goes with it."""
        *state, energy = self._evaluate(cayley_update(x, D, tau))  # Theorem 1, with P^-1 H for H
        return energy, tuple(state)

    def _evaluate(self, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, float]:
        """The map in its gauge, L x, lambda of eq. (9), and the energy."""
        if np.linalg.norm(weighted_sum(self.A, x)) > _OFF_CENTRE * self.A.sum():
            x = center(x, self.A)
        H = self.L @ x
        density = row_dots(x, H)  # twice the image area around each vertex
        return x, H, density, 0.5 * float(density.sum())  # eq. (6)


def _boost(x: FloatArray, g: FloatArray, density: FloatArray) -> FloatArray:
    """Boost to take out of the covector `g` in proportion to the density, so that it sums to zero.

    A uniform shift would load the vertices of limbs, whose image is tiny, as much as all others, and spoil them.
    """
    gram = density.sum() * np.eye(3) - weighted_moment(density, x, x)
    return np.linalg.solve(gram, g.sum(axis=0))
