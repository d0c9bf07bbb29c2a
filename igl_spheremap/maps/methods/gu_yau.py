"""The baseline that the paper compares with: Gu and Yau's descent, from the Gauss map over the Tutte map."""

from __future__ import annotations

import time

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ...descent.gu_yau import GuYau
from ...descent.iterate import Iterate, Listener, Round, Status
from ...descent.minimize import Minimum, minimize
from ...descent.problem import HarmonicEnergy, Problem, harmonic_problem
from ...mesh.check import Mesh
from ...mesh.normals import mesh_gauss_map
from ...untangle.algorithm_2 import in_gauge, record_round
from .draft import Draft

FloatArray = NDArray[np.float64]


def gu_yau(
    mesh: Mesh,
    listener: Listener | None = None,
    *,
    step: float = 1.8,
    uniform: bool = False,
    tutte: bool = True,
    tolerance: float = 1e-3,
    tutte_plateau: float = 1e-3,
    max_iterations: int = 20_000,
    plateau: float = 5e-7,
) -> Draft:
    """Map a mesh as Gu and Yau do: Tutte energy first, then harmonic energy, both by fixed steps.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    listener : callable, optional
        Called with every iterate; those of the Tutte map have round 0, those of the harmonic one round 1.
    step : float
        Step size, between 0 and 2, in the units that `GuYau` explains.
    uniform : bool
        Whether all vertices take the same step.
    tutte : bool
        Whether the Tutte (barycentric) map is made first, as the authors do. Without it the harmonic descent
        starts at the Gauss map, as in the comparisons of Lai et al.
    tolerance : float
        The harmonic descent ends when the L2 norm of the tangential gradient without boosts is at most this:
        the rule of "lai2014", in the same norm.
    tutte_plateau : float
        The Tutte map ends when its energy fell by less than this share over 100 iterations: it is a start
        only.
    max_iterations : int
        Iterations of each of the two at the most.
    plateau : float
        The harmonic descent ends, too, when its energy fell by less than this share over 100 iterations: the
        rule of "lai2014", and in kind that of the authors, an energy difference.

    Returns
    -------
    Draft
        Two rounds, the Tutte map and the harmonic one.

    Raises
    ------
    ValueError
        If the step is not between 0 and 2.

    References
    ----------
    Gu and Yau 2002, *Computing conformal structures of surfaces*; Gu, Wang, Chan, Thompson, Yau 2004,
    algorithms 1 and 2.
    """
    if not 0 < step < 2:
        raise ValueError(f"step {step:g} is unstable; give one between 0 and 2, in units of what the weights allow")
    problem = harmonic_problem(mesh)
    rounds: list[Round] = []

    def descend(name: str, x: FloatArray, stage: str, objective: Problem, flat: float) -> Minimum:
        began = time.perf_counter()
        start = Iterate(name, len(rounds), 0, x, problem.energy.evaluate(x)[0])
        minimum = minimize(
            GuYau(step, uniform, stage).iterates(objective, x),
            tolerance=tolerance,
            plateau=flat,
            max_iterations=max_iterations,
            listener=listener,
            round=len(rounds),
        )
        minimum = in_gauge(problem, minimum)
        rounds.append(record_round(mesh, start, minimum, time.perf_counter() - began))
        return minimum

    name, x = "gauss map", mesh_gauss_map(mesh)
    if tutte:
        minimum = descend(name, x, "tutte", _tutte_problem(mesh, problem), tutte_plateau)
        name, x = "tutte map", minimum.last.x
    if not tutte or minimum.status is not Status.STOPPED:
        minimum = descend(name, x, "harmonic", problem, plateau)
    return Draft(minimum.last.x, minimum.last.energy, minimum.status, tuple(rounds))


def _tutte_problem(mesh: Mesh, problem: Problem) -> Problem:
    """The Tutte energy: all edges weigh the same."""
    n = len(mesh.v)
    start, stop = mesh.f.ravel(), mesh.f[:, [1, 2, 0]].ravel()
    adjacency = sp.csr_matrix((np.ones(len(start)), (start, stop)), shape=(n, n))
    degree = np.asarray(adjacency.sum(axis=1)).ravel()
    return Problem(HarmonicEnergy((sp.diags(degree) - adjacency).tocsr()), problem.A)
