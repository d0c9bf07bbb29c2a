"""The setup of both algorithms for one mesh: the discrete problem, and the hooks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from scipy.sparse import csr_matrix

from ..descent.energies import HarmonicEnergy
from ..descent.problem import Problem, frobenius_metric, l2_metric, laplacian_metric
from ..mesh.arrays import FloatArray
from ..mesh.check import LEAST_AREA, Mesh
from ..mesh.measure import area_normals, vertex_normals, without_direction
from ..operators.laplacian import laplacian_and_notes, printed_laplacian
from ..result.run import Iterate, Listener, Stage
from .hooks import Hooks, nonzero
from .optm import OptMRules
from .settings import Lai2014


@dataclass(frozen=True, eq=False)
class Setup:
    """A mesh, the options, problem (6) on the mesh, the hooks and the listener."""

    mesh: Mesh
    options: Lai2014
    #: The Laplacian, which is the stiffness matrix of eq. (26), too.
    L: csr_matrix
    problem: Problem
    hooks: Hooks
    listener: Listener | None
    notes: tuple[str, ...]

    @classmethod
    def of(cls, mesh: Mesh, options: Lai2014, listener: Listener | None = None) -> Setup:
        """The problem by eq. (13) with the weights and the metric that the options name."""
        if options.edge_weights == "cotangent":
            L, notes = printed_laplacian(mesh), tuple[str, ...]()
        else:
            L, notes = laplacian_and_notes(mesh, "delaunay")
        metrics = {
            "areas": l2_metric(mesh),
            "laplacian": laplacian_metric(L, mesh.areas),
            "vertices": frobenius_metric(mesh),
        }
        metric = metrics[options.metric]
        problem = Problem.of(mesh, HarmonicEnergy(L), metric, options.gauge == "centred")
        raised = int((mesh.areas <= LEAST_AREA / len(mesh.v)).sum())
        if raised and options.metric != "vertices":
            notes = (
                *notes,
                f"{raised:,} vertex areas of eq. (13) were raised to a billionth of their mean",
            )
        hooks = Hooks()
        if options.rules == "program":
            hooks = OptMRules(options.tau)
        return cls(mesh, options, L, problem, hooks, listener, notes)

    def start(self, stage: Stage, x: FloatArray, round: int = 0, **more: Any) -> Iterate:
        """A map for Algorithm 1 to start from."""
        energy = self.problem.energy.evaluate(x)[0]
        return Iterate(stage, round, 0, x, energy, **more)

    def gauss_map(self) -> Iterate:
        """The start of the paper, Definition 1."""
        undirected = int(without_direction(area_normals(self.mesh.unit, self.mesh.f)).sum())
        x = vertex_normals(self.mesh.unit, self.mesh.f)
        return self.start(Stage.GAUSS_MAP, x, safeguards=nonzero(undirected=undirected))
