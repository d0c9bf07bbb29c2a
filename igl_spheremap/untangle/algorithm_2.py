"""Algorithm 2: foldings removed by weighted Laplace-Beltrami eigen-projection."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..descent.algorithm_1 import CayleyBB
from ..descent.iterate import Iterate, Listener, Round, Status
from ..descent.minimize import Minimum, minimize
from ..descent.problem import HarmonicEnergy, Problem
from ..mesh.check import Mesh
from ..sphere.moebius import center
from ..start.star_map import project
from ..verify.certificate import orientation_signs
from ..verify.distortion import mean_angle_difference

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Unfolded:
    """What Algorithm 2 found.

    Attributes
    ----------
    x : (n, 3) float64 array
        The map of the round that left the fewest foldings; of the last such.
    energy : float
        Its energy.
    status : Status
        How that round's minimisation ended, or STOPPED.
    rounds : tuple of Round
        All rounds in order.
    """

    x: FloatArray
    energy: float
    status: Status
    rounds: tuple[Round, ...]


def unfold(
    mesh: Mesh,
    problem: Problem,
    x: FloatArray,
    name: str,
    *,
    solver: CayleyBB,
    tolerance: float,
    max_iterations: int,
    plateau: float,
    rounds: int,
    listener: Listener | None = None,
) -> Unfolded:
    """Alternate Algorithm 1 and eigen-projection until no folding is left.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    problem : Problem
        Its harmonic energy.
    x : (n, 3) float64 array
        The first map.
    name : str
        What it is called in the record.
    solver : CayleyBB
        Algorithm 1.
    tolerance, max_iterations, plateau
        Of Algorithm 1, for each round, see `minimize`.
    rounds : int
        Eigen-projections at the most.
    listener : callable, optional
        Called with every iterate of every round, and with every start.

    Returns
    -------
    Unfolded
        The best map and the record of all rounds.
    """
    done: list[Round] = []
    best: Unfolded | None = None
    x = center(x, problem.A)
    start = Iterate(name, 0, 0, x, problem.energy.evaluate(x)[0])
    for k in range(rounds + 1):
        began = time.perf_counter()
        minimum = _told(start, listener) or minimize(  # Algorithm 2, steps 1 and 4
            solver.iterates(problem, start.x), tolerance=tolerance, max_iterations=max_iterations, plateau=plateau,
            listener=listener, round=start.round)
        minimum = in_gauge(problem, minimum)
        record = record_round(mesh, start, minimum, time.perf_counter() - began)
        done.append(record)
        if best is None or record.foldings_after <= best.rounds[-1].foldings_after:
            best = Unfolded(minimum.last.x, minimum.last.energy, minimum.status, tuple(done))
        if record.foldings_after == 0 or k == rounds or minimum.status is Status.STOPPED:
            break
        start = star_map(mesh, problem, minimum.last.x, k + 1)
    assert best is not None
    status = Status.STOPPED if minimum.status is Status.STOPPED else best.status
    return replace(best, status=status, rounds=tuple(done))


def star_map(mesh: Mesh, problem: Problem, x: FloatArray, round: int) -> Iterate:
    """The start of a round: the star map of the eigenfunctions that `x` weights, Algorithm 2, steps 2 and 3.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    problem : Problem
        Its harmonic energy.
    x : (n, 3) float64 array
        The map before.
    round : int
        Number of the round that starts.

    Returns
    -------
    Iterate
        Its details hold the eigenfunctions ("phi") and their "eigenvalues".
    """
    assert isinstance(problem.energy, HarmonicEnergy)
    projection = project(mesh, problem.energy.L, x)  # Algorithm 2, step 2
    details = {"phi": projection.phi, "eigenvalues": projection.eigenvalues}
    star = center(projection.star_map, problem.A)  # Algorithm 2, step 3
    return Iterate("star map", round, 0, star, problem.energy.evaluate(star)[0], details=details)


def _told(start: Iterate, listener: Listener | None) -> Minimum | None:
    """Tell the listener of a start; if it asks to stop, the start is where the round ends."""
    try:
        if listener is not None:
            listener(start)
    except StopIteration:
        return Minimum(start, Status.STOPPED, np.array([start.energy]), np.array([start.residual]))
    return None


def in_gauge(problem: Problem, minimum: Minimum) -> Minimum:
    """The minimum, re-centred: foldings and energy count as they will be in the gauge of the result.

    Parameters
    ----------
    problem : Problem
        The harmonic energy.
    minimum : Minimum
        Where a minimisation ended.

    Returns
    -------
    Minimum
        Its last map centred, with the harmonic energy there.
    """
    x = center(minimum.last.x, problem.A)
    return replace(minimum, last=replace(minimum.last, x=x, energy=problem.energy.evaluate(x)[0]))


def record_round(mesh: Mesh, start: Iterate, minimum: Minimum, seconds: float) -> Round:
    """What there is to say of a round.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    start : Iterate
        What the minimisation started from.
    minimum : Minimum
        What it came to.
    seconds : float
        Wall time.

    Returns
    -------
    Round
        With the foldings before and after.
    """
    before, after = (int((orientation_signs(x, mesh.f) <= 0).sum()) for x in (start.x, minimum.last.x))
    mean = mean_angle_difference(mesh, minimum.last.x)
    return Round(start.round, start.stage, before, after, minimum.last.iteration, minimum.last.energy, mean,
                 minimum.status, seconds)
