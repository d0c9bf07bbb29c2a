"""Live plots of a run in the panel."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...descent.iterate import Step
from . import style

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: Points of a curve that are drawn at the most.
_POINTS = 2000
_TICKS = np.array([0.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6])


def energy_plot(history: Sequence[Step], at: int, height: float = 130) -> None:
    """Plot how far the energy is above that of a conformal map, over all iterates.

    Parameters
    ----------
    history : sequence of Step
        Of the run so far.
    at : int
        The iterate that is shown.
    height : float
        In pixels.

    Returns
    -------
    None
    """
    from polyscope import implot

    gap = np.array([step.energy for step in history]) - 4 * math.pi
    _plot("energy above 4 pi", np.maximum(np.abs(gap), 1e-12), at, height, implot.ImPlotScale_Log10, style.LINES[0])


def folding_plot(foldings: IntArray, at: int, height: float = 130) -> None:
    """Plot the number of folded faces over all iterates.

    Parameters
    ----------
    foldings : (k,) int64 array
        Of the run so far.
    at : int
        The iterate that is shown.
    height : float
        In pixels.

    Returns
    -------
    None
    """
    from polyscope import implot

    _plot("folded faces", foldings.astype(np.float64), at, height, implot.ImPlotScale_SymLog, style.FOLDED)


def _plot(title: str, y: FloatArray, at: int, height: float, scale: int, colour: style.Colour) -> None:
    from polyscope import implot

    flags = implot.ImPlotFlags_NoLegend | implot.ImPlotFlags_NoMouseText | implot.ImPlotFlags_NoMenus
    fit = implot.ImPlotAxisFlags_AutoFit | implot.ImPlotAxisFlags_NoLabel
    if not implot.BeginPlot(title, (-1, height), flags):
        return
    implot.SetupAxes("iterate", title, fit, fit)
    implot.SetupAxisScale(implot.ImAxis_Y1, scale)
    if scale == implot.ImPlotScale_SymLog:  # it has no ticks of its own
        implot.SetupAxisTicks(implot.ImAxis_Y1, _TICKS, [f"{tick:g}" for tick in _TICKS])
    if len(y):
        x = np.unique(np.linspace(0, len(y) - 1, _POINTS).astype(np.int64))
        implot.SetNextLineStyle((*colour, 1.0), 1.5)
        implot.PlotLine(title, x.astype(np.float64), np.ascontiguousarray(y[x]))
        if scale == implot.ImPlotScale_SymLog:  # so that 0 is always in sight
            implot.SetNextLineStyle((0.0, 0.0, 0.0, 0.0), 1.0)
            implot.PlotLine("none", np.array([0.0, len(y) - 1.0]), np.zeros(2))
        implot.SetNextLineStyle((*style.INK, 0.6), 1.0)
        implot.PlotInfLines("shown", np.array([float(at)]))
    implot.EndPlot()
