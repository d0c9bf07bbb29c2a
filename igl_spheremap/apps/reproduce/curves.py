"""Energy curves and angle histograms: Fig. 4, and the histograms of Fig. 10."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ...verify.distortion import angle_differences
from .canvas import new_figure
from .paper import TABLE_1
from .runs import Outcome, Runs
from .surfaces import Surface, load_surface

_BLUE, _GREY = "#0072B2", "#5A636C"
#: Degrees up to which histograms go.
_REACH = 45.0


def figure_4(runs: Runs, folder: Path | None) -> Any:
    """Fig. 4: harmonic energy by iteration, and histograms of angle differences.

    Parameters
    ----------
    runs : Runs
        Computes or recalls.
    folder : Path, optional
        Folder of meshes.

    Returns
    -------
    matplotlib.figure.Figure
        Not shown.
    """
    figure, axes = new_figure(2, len(TABLE_1), "Fig. 4. Algorithm 1: energy (6) by iteration, and angle differences")
    for column, row in enumerate(TABLE_1):
        surface = load_surface(row.surface, folder)
        outcome = runs.get(surface, "Algorithm 1")
        energy_curve(axes[0][column], outcome)
        axes[0][column].set_title(f"{row.surface}: {surface.source}", fontsize=8)
        histogram(axes[1][column], surface, outcome)
    return figure


def energy_curve(ax: Any, outcome: Outcome) -> None:
    """Energy by iteration, on logarithmic axes, with 4 pi.

    Parameters
    ----------
    ax : matplotlib axes
        Where to.
    outcome : Outcome
        A run.
    """
    ax.loglog(1 + np.arange(len(outcome.energies)), outcome.energies, color=_BLUE)
    ax.axhline(4 * np.pi, color=_GREY, linestyle=":", linewidth=1)
    ax.set(xlabel="iteration + 1", ylabel="energy (dotted: 4 pi)")


def histogram(ax: Any, surface: Surface, outcome: Outcome) -> None:
    """Histogram of the angle differences of a run's result.

    Parameters
    ----------
    ax : matplotlib axes
        Where to.
    surface : Surface
        The source.
    outcome : Outcome
        The run.
    """
    if outcome.foldings < 0:
        ax.set_title("no map", fontsize=8)
        return
    differences = angle_differences(surface.v, surface.f, outcome.sphere).ravel()
    size = np.abs(differences)
    ax.hist(np.clip(differences, -_REACH, _REACH), bins=91, range=(-_REACH, _REACH), color=_BLUE)
    ax.set(xlabel="angle difference (degrees; ends hold the rest)", yticks=[])
    within = 100 * float((size < 5).mean())
    ax.set_title(f"mean {size.mean():.2f}, {within:.0f} percent below 5 degrees", fontsize=8)
