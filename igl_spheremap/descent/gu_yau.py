"""Gradient descent in the tangent spaces with projection back to the sphere: the algorithm of Gu and Yau."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import eigsh

from ..sphere.moebius import conformal_barycentre, moebius
from ..sphere.rows import tangent, unit_rows
from .iterate import Iterate
from .problem import HarmonicEnergy, Problem, remove_boosts

FloatArray = NDArray[np.float64]

#: The mass centre may be this far from the origin: a Newton step from there leaves 1e-8.
_OFF_CENTRE = 1e-4
#: Lanczos finds the largest eigenvalue from below to 1 percent.
_SLACK = 1.02


@dataclass(frozen=True)
class GuYau:
    """Descent by the "absolute derivative" with fixed steps, and zero mass-centre by a Moebius map.

    The derivative is the one of its authors, L x without division by areas: the weights of a Laplacian in the
    plane have no scale, so that this is the better conditioned one where vertices are unevenly spread.

    Parameters
    ----------
    step : float
        Step size: in units of 1 / (sum of the sizes of a vertex's row of L) at each vertex, or, if `uniform`,
        of 1 / (largest eigenvalue of L) at all of them. Up to 1 no step can raise the energy, for normalising
        ``x - step L x`` minimises a quadratic upper bound of it row by row. From 2 on the iteration is
        unstable.
    uniform : bool
        Whether all vertices take the same step, which must be as small as the worst of them demands: a single
        sliver among thousands of vertices makes it ten times smaller.
    stage : str
        What the iterates are called.

    References
    ----------
    Gu and Yau 2002, *Computing conformal structures of surfaces* (reference [1] of Lai et al.); Gu, Wang,
    Chan, Thompson, Yau 2004, *Genus zero surface conformal mapping and its application to brain surface
    mapping*, algorithms 1 and 2. They leave the step to the user.
    """

    step: float = 1.8
    uniform: bool = False
    stage: str = "harmonic"

    def iterates(self, problem: Problem, x: FloatArray) -> Iterator[Iterate]:
        """Yield the start, centred, and every iterate after it, without end.

        Parameters
        ----------
        problem : Problem
            Its energy is a `HarmonicEnergy`.
        x : (n, 3) float64 array
            Start, unit rows.

        Yields
        ------
        Iterate
            Its residual is that of `CayleyBB`: the L2 norm of the tangential gradient without boosts.
        """
        assert isinstance(problem.energy, HarmonicEnergy)
        L = problem.energy.L
        bound = largest_eigenvalue(L) if self.uniform else np.asarray(abs(L).sum(axis=1)).reshape(-1, 1)
        tau = self.step / np.maximum(bound, np.finfo(float).tiny)
        for k in count():
            x = _zero_mass_centre(x, problem.A)
            energy, derivative = problem.energy.evaluate(x)
            D = tangent(x, derivative)
            gradient = remove_boosts(x, D / problem.A[:, None], problem.A)
            residual = np.sqrt(problem.inner(gradient, gradient))
            yield Iterate(self.stage, 0, k, x, energy, float(residual), float(np.median(tau)) if k else 0.0)
            x = unit_rows(x - tau * D)


def largest_eigenvalue(L: sp.csr_matrix) -> float:
    """Upper bound of the spectrum of a positive semidefinite matrix, tight to a few percent.

    Parameters
    ----------
    L : (n, n) sparse matrix
        Symmetric.

    Returns
    -------
    float
        By Lanczos from a fixed start; Gershgorin's bound for matrices too small for it.

    Examples
    --------
    >>> L = sp.diags_array(np.arange(10.0) ** 3).tocsr()
    >>> largest_eigenvalue(L)
    729.0
    """
    gershgorin = float(abs(L).sum(axis=1).max())
    n = L.shape[0]
    if n <= 32:
        return gershgorin
    start = np.cos(np.arange(n) * 1.6180339887)  # fixed, so that every run gives the same numbers
    value = eigsh(L, k=1, which="LA", v0=start, tol=1e-3, return_eigenvectors=False)[0]
    return min(gershgorin, _SLACK * float(value))


def _zero_mass_centre(x: FloatArray, A: FloatArray) -> FloatArray:
    """The map after the Moebius map that takes its mass centre to the origin, if it has left it."""
    c = conformal_barycentre(x, A, _OFF_CENTRE)
    return moebius(x, c) if c.any() else x
