"""Algorithm 1: Cayley updates with Barzilai-Borwein steps and a nonmonotone search."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import count

import numpy as np

from ..descent.line_search import line_search
from ..descent.minimize import State, minimize_round
from ..descent.problem import Problem
from ..mesh.arrays import FloatArray
from ..result.run import Iterate, Round, Stage
from ..sphere.cayley import cayley_step
from .hooks import Hooks
from .settings import Lai2014, Quotients
from .setup import Setup


def algorithm_1(setup: Setup, start: Iterate) -> tuple[Iterate, Round]:
    """Minimise the energy from a start, and count the foldings before and after.

    The listener sees the start, and every iterate after it.
    """
    options = setup.options
    return minimize_round(
        setup.mesh,
        start.stage,
        start.x,
        cayley_bb(setup.problem, start.x, setup.hooks, options),
        Stage.ALGORITHM_1,
        round=start.round,
        first=start,
        tolerance=options.gradient_tolerance,
        max_iterations=options.max_iterations,
        plateau=options.plateau,
        settled=setup.hooks.settled,
        end=partial(setup.hooks.end, start),
        listener=setup.listener,
    )


def cayley_bb(
    problem: Problem,
    F: FloatArray,
    hooks: Hooks,
    options: Lai2014 = Lai2014(),  # noqa: B008
) -> Iterator[State]:
    """Yield the start and every state after it of Algorithm 1, for any energy and metric; `minimize` has step 2.

    The states end when no step is acceptable. Their residual is that of the metric, by eq. (9) the L2 norm of A F in
    the L2 metric.

    Lai et al., Algorithm 1; Wen and Yin 2013, *A feasible method for optimization with orthogonality constraints*.
    """
    F, tau, taken = hooks.start(F), options.tau, 0.0
    E, AF = problem.evaluate(F)
    search = hooks.search(E, options.rho, options.delta, options.xi)  # Algorithm 1, step 1

    for k in count():  # Algorithm 1, step 6
        yield State(k, F, E, problem.metric.residual(AF), taken, safeguards=hooks.acted())
        slope = -problem.metric.inner(AF, AF)  # E'(Y(0)) = -|A F|^2
        path = partial(_path, F, AF, hooks)
        step = line_search(search, problem.energy, path, tau, slope)  # Algorithm 1, step 3
        if step is None:
            return
        taken, Y, E, H = step
        search.record(E)  # Algorithm 1, step 5
        AY = problem.gradient(Y, H)
        D, W = Y - F, AY - AF
        F, AF = Y, AY  # Algorithm 1, step 4
        tau = hooks.step(_quotient(problem, D, W, options.bb, k + 1), taken)


def _path(F: FloatArray, AF: FloatArray, hooks: Hooks, tau: float) -> FloatArray | None:
    """A step's map; None if it is refused."""
    return hooks.trial(cayley_step(F, AF, tau))  # Theorem 1


def _quotient(problem: Problem, D: FloatArray, W: FloatArray, bb: Quotients, k: int) -> float:
    """Step that iteration `k` tries first, eq. (12); without a value it is 0, infinite or a NaN."""
    DW = abs(problem.metric.inner(D, W))
    odd = k % 2 == 1
    if bb == "tau_1" or (bb == "tau_1 first" and odd) or (bb == "tau_2 first" and not odd):
        return float(np.divide(problem.metric.inner(D, D), DW))  # eq. (12), tau_{k,1}
    return float(np.divide(DW, problem.metric.inner(W, W)))  # eq. (12), tau_{k,2}
