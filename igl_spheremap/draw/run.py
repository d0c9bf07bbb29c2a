"""Plots of a run: its energy and its foldings by iterate, and the result's changes of angles and areas."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..mesh.arrays import FloatArray, IntArray
from ..result.run import Step, iterations_in
from .palette import FOLDED, GUIDE, INK, LINES
from .plot import SMALL, extremes, new_figure, plot_angles, plot_areas


def plot_run(
    history: Sequence[Step],
    foldings: ArrayLike | None,
    differences: FloatArray,
    ratios: FloatArray,
    *,
    title: str = "",
) -> Any:
    """Plot energy and folded faces of every iterate, and the result's changes of angles and areas.

    It takes angle differences (m, 3) in degrees and logarithms of area ratios (m,). A sentence stands in place of a
    curve of two points, or of zeros; without foldings their curve is missing. Lai et al., Figs. 4 and 10.
    """
    at, values, name = objective(history)
    counts = None
    if foldings is not None:
        counts = np.asarray(foldings)
    said = []
    if curved := len(values) > 2:
        said.append(iterations_in(sum(step.iteration > 0 for step in history)))
    elif len(values):
        said.append(f"{name}: {' to '.join(f'{value:.3g}' for value in values)}")
    if counts is not None and not counts.any():
        said.append("no face is folded in any iterate")
        counts = None
    columns = [curved, counts is not None].count(True)
    shape = {0: (1, 2), 1: (1, 3), 2: (2, 2)}[columns]  # four in a row would be small
    figure, axes = new_figure(*shape, "\n".join(filter(None, (title, "; ".join(said)))), (3.6, 3.0))
    *curves, angles, areas = axes.ravel()
    if curved:
        energy = curves[0]
        drawn = extremes(values)
        energy.plot(at[drawn], values[drawn], color=LINES[0], marker=_marker(values))
        linear = linear_below(values)
        if linear == 0:
            energy.set_yscale("log")
        elif np.isfinite(linear):
            energy.set_yscale("symlog", linthresh=linear)
        energy.set_title(name, fontsize=SMALL + 1)
    if counts is not None:
        most = counts.max()
        drawn = extremes(counts)
        curves[-1].plot(drawn, counts[drawn], color=FOLDED, marker=_marker(counts))
        if most > 9:  # else each number has a tick
            curves[-1].set_yscale("symlog", linthresh=1)
            curves[-1].set_ylim(bottom=-0.2)
        else:
            curves[-1].set(ylim=(-0.1, most + 0.1), yticks=range(most + 1))
        curves[-1].set_title("folded faces", fontsize=SMALL + 1)
    for ax in curves:
        ax.xaxis.get_major_locator().set_params(integer=True)
        ax.set_xlabel("iterate", fontsize=SMALL)
        ax.tick_params(labelsize=SMALL)
        _mark_rounds(ax, history)
    plot_angles(angles, differences)
    plot_areas(areas, ratios)
    return figure


def objective(history: Sequence[Step], near: float = 1.0) -> tuple[IntArray, FloatArray, str]:
    """Places in the history, values and name of the last objective.

    If the energy ends near 4 pi, its value for a smooth conformal map, as the harmonic energy with or without
    landmarks, it is that minus 4 pi; else the energy minus its minimum.

    >>> from igl_spheremap.result.run import Stage, Step
    >>> energies = (Stage.ALGORITHM_1, 13.0), (Stage.BALANCE, 5.0), (Stage.BALANCE, 3.0)
    >>> at, values, name = objective([Step(stage, 0, 0, energy, 0.0, 0.0) for stage, energy in energies])
    >>> at.tolist(), values.tolist(), name
    ([1, 2], [2.0, 0.0], 'energy of the balance above its minimum')
    """
    last = ""
    if history:
        last = _minimised(history[-1])
    same = [
        k
        for k, step in enumerate(history)
        if _minimised(step) == last and math.isfinite(step.energy)
    ]
    at, energies = np.array(same, dtype=np.int64), np.array([history[k].energy for k in same])
    if not same:
        return at, energies, "energy"
    least = float(energies.min())
    if last:
        return at, energies - least, f"energy of the {last} above its minimum"
    if abs(least - 4 * math.pi) < near:
        return at, energies - 4 * math.pi, "energy minus 4π"
    return at, energies - least, "energy above its minimum"


def _minimised(step: Step) -> str:
    """The stage of a step that minimises an energy of its own; empty for the harmonic energy."""
    if step.stage.has_own_energy:
        return step.stage
    return ""


def linear_below(values: FloatArray, wide: float = 30.0) -> float:
    """Limit between the linear and the logarithmic part of an axis that shows all values.

    If a logarithmic axis serves, 0; if values have no wider ratio, so that a linear one does, infinity.

    >>> [linear_below(np.array(values)) for values in ([200.0, 1e-3], [2e-3, -1e-3], [9.0, -0.01])]
    [0.0, inf, 0.01]
    """
    above, below = max(float(values.max(initial=0)), 0.0), max(-float(values.min(initial=0)), 0.0)
    positive = values[values > 0]
    if below and above > wide * below:
        return below
    if not below and len(positive) > 1 and above > wide * float(positive.min()):
        return 0.0
    return math.inf


def _marker(values: NDArray[Any]) -> str | None:
    if len(values) < 30:
        return "."
    return None


def round_starts(history: Sequence[Step]) -> list[tuple[int, str]]:
    """First iterates of the rounds of Algorithm 2, as places in the history, and their stages."""
    return [
        (k, step.stage) for k, step in enumerate(history) if k and step.round > history[k - 1].round
    ]


def _mark_rounds(ax: Any, history: Sequence[Step]) -> None:
    """A line where each round begins."""
    for k, stage in round_starts(history):
        ax.axvline(k, color=GUIDE, linestyle=":", linewidth=1)
        ax.annotate(stage, (k, 1), xycoords=("data", "axes fraction"), fontsize=SMALL, color=INK, rotation=90,
                    ha="left", va="top")  # fmt: skip
