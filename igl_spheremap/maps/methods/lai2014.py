"""The paper: Algorithm 2 around Algorithm 1, from the Gauss map."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ...descent.algorithm_1 import BarzilaiBorwein, CayleyBB
from ...descent.iterate import Iterate, Listener
from ...descent.minimize import Minimum, minimize
from ...descent.problem import harmonic_problem
from ...mesh.check import Mesh
from ...mesh.normals import mesh_gauss_map
from ...untangle.algorithm_2 import unfold
from ...untangle.candidate import Candidate
from .method import Method


@dataclass(frozen=True)
class Lai2014(Method):
    """The method "lai2014", the paper's: Algorithm 2 around Algorithm 1, from the Gauss map.

    Parameters
    ----------
    tolerance : float
        Each minimisation ends when the L2 norm of the tangential gradient A F, eq. (9), is at most this, the source
        having unit area. The Gauss map starts near 1e3; below 1e-3 the rounding of the energy hides all progress.
    max_iterations : int
        Iterations at the most, counted anew for each round.
    plateau : float
        Each minimisation ends, too, when its lowest energy fell by less than this share over the last 100 iterations:
        limbs creep for thousands of iterations after all else has settled.
    rounds : int
        Eigen-projections at the most; 0 is Algorithm 1 alone.
    rho : float
        Share of the predicted decrease that a step must reach.
    delta : float
        Factor by which a refused step is shortened.
    xi : float
        Memory of the nonmonotone search: 0 is the monotone Armijo search, 1 averages over all iterates.
    bb : {"alternating", "tau_1", "tau_2"}
        Which Barzilai-Borwein quotient of eq. (12) is the first step tried; "alternating" takes tau_1 at odd
        iterations and tau_2 at even ones.

    References
    ----------
    Lai, Wen, Yin, Gu, Lui 2014, Algorithms 1 and 2.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=500)
    >>> ism.spherical_conformal_map(v, f, ism.Lai2014(tolerance=1e-2, rounds=1)).certificate.folding_free
    True
    """

    name: ClassVar[str] = "lai2014"
    tolerance: float = 1e-3
    max_iterations: int = 5000
    plateau: float = 5e-7
    rounds: int = 3
    rho: float = 1e-4
    delta: float = 0.1
    xi: float = 0.85
    bb: BarzilaiBorwein = "alternating"

    def run(
        self, mesh: Mesh, listener: Listener | None = None, x0: NDArray[np.float64] | None = None
    ) -> Candidate:
        """Map a mesh from the Gauss map, or from another start, of unit rows."""
        problem = harmonic_problem(mesh)
        solver = CayleyBB(rho=self.rho, delta=self.delta, xi=self.xi, bb=self.bb, keep_injective=True)

        def algorithm_1(start: Iterate) -> Minimum:
            return minimize(solver.iterates(problem, start.x), tolerance=self.tolerance,
                            max_iterations=self.max_iterations, plateau=self.plateau, listener=listener,
                            round=start.round)

        x, name = (mesh_gauss_map(mesh), "gauss map") if x0 is None else (x0, "given map")
        return unfold(mesh, problem, x, name, algorithm_1, self.rounds, listener)
