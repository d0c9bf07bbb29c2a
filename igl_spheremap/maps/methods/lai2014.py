"""The paper: Algorithm 2 around Algorithm 1, from the Gauss map."""

from __future__ import annotations

from ...descent.algorithm_1 import CayleyBB
from ...descent.energies.harmonic import HarmonicEnergy
from ...descent.minimize import Minimum, minimize
from ...descent.problem import Problem
from ...mesh.arrays import FloatArray
from ...mesh.check import Mesh
from ...mesh.measure import vertex_normals
from ...result.run import Iterate, Listener
from ...untangle.algorithm_2 import unfold
from ...untangle.candidate import Candidate
from ..options import Lai2014

#: Eigen-projections in a row with weights that are never negative: star maps of star maps approach a conformal map.
_PROJECTIONS = 40


def lai2014(mesh: Mesh, options: Lai2014, listener: Listener, x0: FloatArray | None = None) -> Candidate:
    """Map a mesh from the Gauss map, or from another start, of unit rows."""
    energy = HarmonicEnergy.of(mesh, options.weights)
    problem = Problem.of(mesh, energy)
    solver = CayleyBB(rho=options.rho, delta=options.delta, xi=options.xi, bb=options.bb, keep_injective=True)

    def algorithm_1(start: Iterate) -> Minimum:
        return minimize(solver.iterates(problem, start.x), tolerance=options.tolerance,
                        max_iterations=options.max_iterations, plateau=options.plateau, listener=listener,
                        round=start.round)

    x, name = (vertex_normals(mesh.v, mesh.f), "gauss map") if x0 is None else (x0, "given map")
    projections = _PROJECTIONS if options.weights == "delaunay" else 1
    return unfold(mesh, problem, energy.L, x, name, algorithm_1, options.rounds, listener, projections)
