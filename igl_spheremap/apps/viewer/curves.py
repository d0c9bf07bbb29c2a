"""Live plots of a run in the panel."""

from __future__ import annotations

import math

import numpy as np

from ...draw import palette
from ...mesh.arrays import FloatArray, IntArray
from .lazy import implot

#: Points of a curve that are drawn at the most.
_POINTS = 500
_TICKS = np.array([0.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6])


def energy_plot(at: IntArray, energies: FloatArray, shown: int, height: float) -> None:
    """Plot how far energies are above that of a conformal map, over the iterates `at`."""
    gap = np.maximum(np.abs(energies - 4 * math.pi), 1e-12)
    known = np.isfinite(gap)
    _plot("energy above 4 pi", at[known], gap[known], shown, height, implot.ImPlotScale_Log10, palette.LINES[0])


def folding_plot(at: IntArray, foldings: IntArray, shown: int, height: float) -> None:
    """Plot the number of folded faces over the iterates `at`."""
    _plot("folded faces", at, foldings.astype(np.float64), shown, height, implot.ImPlotScale_SymLog, palette.FOLDED)


def _plot(
    title: str, x: IntArray, y: FloatArray, shown: int, height: float, scale: int, colour: palette.Colour
) -> None:
    flags = implot.ImPlotFlags_NoLegend | implot.ImPlotFlags_NoMouseText | implot.ImPlotFlags_NoMenus
    fit = implot.ImPlotAxisFlags_AutoFit | implot.ImPlotAxisFlags_NoLabel
    if not implot.BeginPlot(title, (-1, height), flags):
        return
    implot.SetupAxes("iterate", title, fit, fit)
    implot.SetupAxisScale(implot.ImAxis_Y1, scale)
    if scale == implot.ImPlotScale_SymLog:  # it has no ticks of its own
        implot.SetupAxisTicks(implot.ImAxis_Y1, _TICKS, [f"{tick:g}" for tick in _TICKS])
    if len(y):
        chosen = np.unique(np.linspace(0, len(y) - 1, _POINTS).astype(np.int64))
        implot.SetNextLineStyle((*colour, 1.0), 1.5)
        implot.PlotLine(title, x[chosen].astype(np.float64), np.ascontiguousarray(y[chosen]))
        if scale == implot.ImPlotScale_SymLog:  # so that 0 is always in sight
            implot.SetNextLineStyle((0.0, 0.0, 0.0, 0.0), 1.0)
            implot.PlotLine("none", np.array([x[0], x[-1]], dtype=np.float64), np.zeros(2))
        implot.SetNextLineStyle((*palette.INK, 0.6), 1.0)
        implot.PlotInfLines("shown", np.array([float(shown)]))
    implot.EndPlot()
