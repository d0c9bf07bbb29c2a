"""The baseline that the paper compares with: Gu and Yau's descent, from the Gauss map over the Tutte map."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ...descent.energies.harmonic import HarmonicEnergy
from ...descent.gu_yau import ProjectedDescent, step_metric
from ...descent.iterate import Iterate, Listener, Round, Status
from ...descent.minimize import Minimum, minimize
from ...descent.problem import Problem, harmonic_problem
from ...mesh.check import Mesh
from ...mesh.normals import mesh_gauss_map
from ...operators.laplacian import laplacian, usable_laplacian
from ...untangle.candidate import Candidate
from .method import Method

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class GuYau(Method):
    """The method "gu-yau": Tutte energy first, then harmonic energy, both by gradient descent with fixed steps.

    Iterates of the Tutte map have round 0, those of the harmonic map round 1.

    Parameters
    ----------
    step : float
        Step size, between 0 and 2: in units of 1 / (sum of the sizes of a vertex's row of the Laplacian) at each
        vertex, or, if `uniform`, of 1 / (its largest eigenvalue) at all of them.
    uniform : bool
        Whether all vertices take the same step.
    tutte : bool
        Whether the Tutte (barycentric) map is made first, as the authors do. Without it the harmonic descent
        starts at the Gauss map, as in the comparisons of Lai et al.
    tolerance : float
        The harmonic descent ends when the L2 norm of the tangential gradient without boosts is at most this:
        the rule of `Lai2014`, in the same norm.
    tutte_plateau : float
        The Tutte map ends when its energy fell by less than this share over 100 iterations: it is a start
        only.
    max_iterations : int
        Iterations at the most, counted for each of the two maps.
    plateau : float
        The harmonic descent ends, too, when its energy fell by less than this share over 100 iterations: the
        rule of `Lai2014`, and in kind that of the authors, an energy difference.

    Raises
    ------
    ValueError
        If the step is not between 0 and 2.

    References
    ----------
    Gu and Yau 2002, *Computing conformal structures of surfaces*; Gu, Wang, Chan, Thompson, Yau 2004,
    algorithms 1 and 2.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=500)
    >>> [r.start for r in ism.spherical_conformal_map(v, f, ism.GuYau(tutte=False)).rounds]
    ['gauss map']
    """

    name: ClassVar[str] = "gu-yau"
    step: float = 1.8
    uniform: bool = False
    tutte: bool = True
    tolerance: float = 1e-3
    tutte_plateau: float = 1e-3
    max_iterations: int = 20_000
    plateau: float = 5e-7

    def __post_init__(self) -> None:
        """Refuse steps that diverge before anything is computed."""
        if not 0 < self.step < 2:
            raise ValueError(
                f"step {self.step:g} is unstable; give one between 0 and 2, in units of what the weights allow"
            )

    def run(self, mesh: Mesh, listener: Listener | None = None) -> Candidate:
        """Map a mesh."""
        harmonic = harmonic_problem(mesh)
        rounds: list[Round] = []

        def descend(name: str, x: FloatArray, stage: str, L: sp.csr_matrix, plateau: float) -> Minimum:
            began = time.perf_counter()
            start = Iterate(name, len(rounds), 0, x, harmonic.energy.evaluate(x)[0])
            problem = Problem.of(mesh, HarmonicEnergy(L), step_metric(L, self.uniform))
            minimum = minimize(
                ProjectedDescent(self.step, stage).iterates(problem, x),
                tolerance=self.tolerance,
                plateau=plateau,
                max_iterations=self.max_iterations,
                listener=listener,
                round=len(rounds),
            ).centred(harmonic)
            rounds.append(minimum.as_round(mesh, start, time.perf_counter() - began))
            return minimum

        name, x = "gauss map", mesh_gauss_map(mesh)
        if self.tutte:
            minimum = descend(name, x, "tutte", laplacian(mesh.v, mesh.f, "uniform"), self.tutte_plateau)
            name, x = "tutte map", minimum.last.x
        if not self.tutte or minimum.status is not Status.STOPPED:
            minimum = descend(name, x, "harmonic", usable_laplacian(mesh.v, mesh.f), self.plateau)
        return Candidate(minimum.last.x, minimum.last.energy, minimum.status, tuple(rounds))
