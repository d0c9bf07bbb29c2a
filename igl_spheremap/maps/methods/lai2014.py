"""The paper: Algorithm 2 around Algorithm 1, from the Gauss map."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...descent.algorithm_1 import CayleyBB
from ...descent.iterate import Listener
from ...descent.problem import harmonic_problem
from ...mesh.check import Mesh
from ...mesh.normals import mesh_gauss_map
from ...untangle.algorithm_2 import unfold
from .draft import Draft

FloatArray = NDArray[np.float64]


def lai2014(
    mesh: Mesh,
    listener: Listener | None = None,
    *,
    x0: FloatArray | None = None,
    tolerance: float = 1e-3,
    max_iterations: int = 5000,
    plateau: float = 5e-7,
    rounds: int = 3,
    rho: float = 1e-4,
    delta: float = 0.1,
    xi: float = 0.85,
    bb: Literal["alternating", "tau_1", "tau_2"] = "alternating",
) -> Draft:
    """Map a mesh as Lai et al. do.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    listener : callable, optional
        Called with every iterate.
    x0 : (n, 3) float64 array, optional
        Start, unit rows; the Gauss map by default.
    tolerance : float
        Each minimisation ends when the L2 norm of the tangential gradient A F, eq. (9), is at most this, the source
        having unit area. The Gauss map starts near 1e3; below 1e-3 the rounding of the energy hides all progress.
    max_iterations : int
        Iterations of each minimisation at the most.
    plateau : float
        Each minimisation ends, too, when its lowest energy fell by less than this share over the last 100 iterations:
        limbs creep for thousands of iterations after all else has settled.
    rounds : int
        Eigen-projections at the most; 0 is Algorithm 1 alone.
    rho, delta, xi : float
        Of the nonmonotone search, see `CayleyBB`.
    bb : {"alternating", "tau_1", "tau_2"}
        Barzilai-Borwein quotient of eq. (12).

    Returns
    -------
    Draft
        The map of the round with the fewest foldings.
    """
    problem = harmonic_problem(mesh)
    solver = CayleyBB(rho=rho, delta=delta, xi=xi, bb=bb, confine_to=mesh.f)
    start, name = (mesh_gauss_map(mesh), "gauss map") if x0 is None else (x0, "given map")
    found = unfold(mesh, problem, start, name, solver=solver, tolerance=tolerance, max_iterations=max_iterations,
                   plateau=plateau, rounds=rounds, listener=listener)
    return Draft(found.x, found.energy, found.status, found.rounds)
