"""The descent of Gu and Yau, the paper's rival."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count

from ..mesh.arrays import FloatArray
from ..sphere.rows import unit_rows
from ..start.punctured import OFF_CENTRE
from .minimize import State
from .problem import Diagonal, Problem, remove_boosts


def projected_descent(
    problem: Problem, L2: Diagonal, x: FloatArray, step: float = 1.8
) -> Iterator[State]:
    """Yield the start, centred, and every state after it, without end.

    Descent by the "absolute derivative" with fixed steps, and zero mass-centre by a Moebius map. The `step` is in the
    problem's metric, see `laplacian_metric`. Steps up to 1 can't raise the energy, since normalising ``x - step K^-1 L
    x`` minimises a quadratic upper bound of it row by row. From 2 on the iteration is unstable.

    The states' residual is that of `cayley_bb` in all metrics: the L2 norm of the gradient without boosts.

    Gu and Yau 2002, *Computing conformal structures of surfaces* (reference [1] of Lai et al.); Gu, Wang, Chan,
    Thompson, Yau 2004, *Genus zero surface conformal mapping and its application to brain surface mapping*,
    algorithms 1 and 2. They leave the step to the user.
    """
    taken = 0.0
    for k in count():
        x = problem.centred(x, OFF_CENTRE)
        energy, derivative = problem.energy.evaluate(x)
        gradient = remove_boosts(x, L2.gradient(x, derivative), problem.A)
        yield State(k, x, energy, L2.residual(gradient), taken)
        x, taken = unit_rows(x - step * problem.metric.gradient(x, derivative)), step
