"""Algorithm 1: Cayley updates with Barzilai-Borwein steps and a nonmonotone search."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain, count

import numpy as np

from ..descent.minimize import Minimum, minimize
from ..descent.problem import Problem
from ..mesh.arrays import FloatArray
from ..result.run import Iterate, Round
from ..sphere.cayley import cayley_step
from .safeguards import AsPrinted
from .settings import Lai2014, Quotients
from .setup import Setup


def algorithm_1(setup: Setup, start: Iterate) -> tuple[Minimum, Round]:
    """Minimise the energy from a start, and count the foldings before and after.

    The listener sees the start, and every iterate after it.
    """
    options = setup.options
    minimum = minimize(
        chain([start], cayley_bb(setup.problem, start.x, setup.beside, options)),
        tolerance=options.gradient_tolerance,
        max_iterations=options.max_iterations,
        plateau=options.plateau,
        settled=setup.beside.settled,
        listener=setup.listener,
        round=start.round,
    )
    return minimum, minimum.as_round(setup.mesh, start)


def cayley_bb(
    problem: Problem,
    F: FloatArray,
    beside: AsPrinted,
    options: Lai2014 = Lai2014(),  # noqa: B008
) -> Iterator[Iterate]:
    """Yield the start and every iterate after it of Algorithm 1, for any energy and metric; `minimize` has step 2.

    The iterates end where no step is acceptable. Their residual is `Problem.residual`, by eq. (9) the L2 norm of A F in
    the L2 metric.

    Lai et al., Algorithm 1; Wen and Yin 2013, *A feasible method for optimization with orthogonality constraints*.
    """
    F = beside.start(F)
    E, AF = problem.evaluate(F)
    search = beside.search(E, options.rho, options.delta, options.xi)  # Algorithm 1, step 1
    tau, taken = options.tau, 0.0
    for k in count():  # Algorithm 1, step 6
        yield Iterate(
            "harmonic", 0, k, F, E, problem.residual(AF), taken, safeguards=beside.acted()
        )
        slope = -problem.metric.inner(AF, AF)  # E'(Y(0)) = -|A F|^2
        for taken in search.steps(tau):  # Algorithm 1, step 3
            Y = beside.trial(cayley_step(F, AF, taken))  # Theorem 1
            if Y is None:
                continue
            E, H = problem.energy.evaluate(Y)
            if search.accepts(E, taken, slope):
                break
        else:
            return
        search.record(E)  # Algorithm 1, step 5
        AY = problem.gradient(Y, H)
        D, W = Y - F, AY - AF
        F, AF = Y, AY  # Algorithm 1, step 4
        tau = beside.step(_quotient(problem, D, W, options.bb, k + 1), taken)


def _quotient(problem: Problem, D: FloatArray, W: FloatArray, bb: Quotients, k: int) -> float:
    """Step that iteration `k` tries first, eq. (12); 0, infinite or a NaN where it has no value."""
    DW = abs(problem.metric.inner(D, W))
    if bb == "tau_1" or bb == ("tau_1 first" if k % 2 else "tau_2 first"):
        return float(np.divide(problem.metric.inner(D, D), DW))  # eq. (12), tau_{k,1}
    return float(np.divide(DW, problem.metric.inner(W, W)))  # eq. (12), tau_{k,2}
