"""The loop around every first-order solver: it draws states, notifies a listener, and decides when to end."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from functools import partial
from itertools import chain, starmap
from typing import Any, NamedTuple

from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..result.run import Iterate, Listener, Round, Stage, Status
from ..verify.certificate import Certificate
from ..verify.distortion import mean_angle_difference


class State(NamedTuple):
    """A map that a solver yields. `minimize` knows the stage and the round, and makes an `Iterate` of all three."""

    iteration: int
    x: FloatArray
    energy: float
    residual: float
    tau: float = 0.0
    details: dict[str, Any] | None = None
    safeguards: dict[str, int] | None = None


def minimize(
    states: Iterator[State],
    stage: Stage,
    *,
    tolerance: float,
    max_iterations: int,
    plateau: float = 0.0,
    settled: Callable[[Iterate], bool] | None = None,
    listener: Listener | None = None,
    round: int = 0,
    first: Iterate | None = None,
) -> tuple[Iterate, Status]:
    """Run a solver until its residual is at most the tolerance, Algorithm 1, step 2; return the last iterate, and why
    it ends.

    The solver yields its start, then every state after it, and ends when no step is acceptable. Each solver defines its
    residual. When `settled`, a rule of its own, is true of an iterate, the run has also converged. It ends at a plateau
    when the lowest energy fell by less than the share `plateau` over the last 100 steps; 0 switches this rule off. A
    listener may raise StopIteration. If `first` is given, it comes before the solver's iterates.
    """
    iterates: Iterator[Iterate] = starmap(partial(Iterate, stage, round), states)
    if first is not None:
        iterates = chain([first], iterates)
    energies: list[float] = []
    for last in iterates:
        energies.append(last.energy)
        try:
            if listener is not None:
                listener(last)
        except StopIteration:
            return last, Status.STOPPED
        # Algorithm 1, step 2
        if last.residual <= tolerance or (settled is not None and settled(last)):
            return last, Status.CONVERGED
        if _is_flat(energies, plateau):
            return last, Status.PLATEAU
        if last.iteration >= max_iterations:
            return last, Status.MAX_ITERATIONS
    return last, Status.STALLED


def minimize_round(
    mesh: Mesh,
    start: str,
    x: FloatArray,
    states: Iterator[State],
    stage: Stage,
    *,
    round: int = 0,
    end: Callable[[Iterate], Iterate] | None = None,
    **rules: Any,
) -> tuple[Iterate, Round]:
    """`minimize` by its `rules` from the map `x`, called `start`, and count the foldings before and after.

    `end` may put another iterate in the place of the last one, unless the listener has stopped the run.
    A map of degree 0 has collapsed.
    """
    began = time.perf_counter()
    last, status = minimize(states, stage, round=round, **rules)
    if end is not None and status is not Status.STOPPED:
        last = end(last)
    seconds = time.perf_counter() - began
    before, after = Certificate.of(x, mesh.f), Certificate.of(last.x, mesh.f)
    if after.degree == 0 and status is not Status.STOPPED:
        status = Status.COLLAPSED
    return last, Round(
        round=round,
        start=str(start),
        foldings_before=before.foldings,
        foldings_after=after.foldings,
        iterations=last.iteration,
        energy=last.energy,
        mean_angle_difference=mean_angle_difference(mesh, last.x),
        status=status,
        seconds=seconds,
    )


def _is_flat(energies: list[float], plateau: float, window: int = 100) -> bool:
    """True if the lowest energy fell by less than the share `plateau` of it over the last steps.

    Barzilai-Borwein energies oscillate with periods of tens, so shorter windows would see false plateaus.
    """
    if plateau == 0 or len(energies) % window or len(energies) <= window:
        return False
    lowest = min(energies)
    return min(energies[:-window]) - lowest < plateau * lowest
