"""What both algorithms need for one mesh: the discrete problem, and the safeguards."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix

from ..descent.energies import HarmonicEnergy
from ..descent.problem import Diagonal, Problem, step_metric
from ..mesh.arrays import FloatArray
from ..mesh.check import LEAST_AREA, Mesh
from ..mesh.measure import area_normals, vertex_normals, without_direction
from ..operators.laplacian import laplacian_and_notes, printed_laplacian
from ..result.run import Iterate, Listener
from .program import AsProgrammed
from .safeguards import AsPrinted, Safeguards, nonzero
from .settings import Lai2014


@dataclass(frozen=True, eq=False)
class Setup:
    """A mesh, the options, problem (6) on the mesh, the safeguards (`beside`) and the listener."""

    mesh: Mesh
    options: Lai2014
    #: The Laplacian, which is the stiffness matrix of eq. (26), too.
    L: csr_matrix
    problem: Problem
    beside: AsPrinted
    listener: Listener | None
    notes: tuple[str, ...]

    @classmethod
    def of(cls, mesh: Mesh, options: Lai2014, listener: Listener | None = None) -> Setup:
        """The problem by eq. (13) with the weights and the metric that the options name."""
        printed = options.edge_weights == "cotangent"
        L, notes = (
            (printed_laplacian(mesh), ()) if printed else laplacian_and_notes(mesh, "delaunay")
        )
        metric = {
            "areas": None,
            "laplacian": step_metric(L),
            "vertices": Diagonal(np.ones(len(mesh.v))),
        }
        problem = Problem.of(
            mesh, HarmonicEnergy(L), metric[options.metric], options.gauge == "centred"
        )
        if options.metric == "vertices":
            # so the gradient has the Frobenius norm: no areas are used
            problem = replace(problem, share=None)
        elif raised := int((problem.areas <= LEAST_AREA / len(mesh.v)).sum()):
            notes = (
                *notes,
                f"{raised:,} vertex areas of eq. (13) were raised to a billionth of their mean",
            )
        if options.rules == "program":
            beside: AsPrinted = AsProgrammed(options.tau)
        elif options.may_fold and not problem.gauge:
            beside = AsPrinted()
        else:
            beside = Safeguards(mesh, problem, options.may_fold)
        return cls(mesh, options, L, problem, beside, listener, notes)

    def start(self, name: str, x: FloatArray, round: int = 0, **more: Any) -> Iterate:
        """A map for Algorithm 1 to start from."""
        return Iterate(name, round, 0, x, self.problem.energy.evaluate(x)[0], **more)

    def gauss_map(self) -> Iterate:
        """The start of the paper, Definition 1."""
        undirected = int(without_direction(area_normals(self.mesh.unit, self.mesh.f)).sum())
        x = vertex_normals(self.mesh.unit, self.mesh.f)
        return self.start("gauss map", x, safeguards=nonzero(undirected=undirected))
