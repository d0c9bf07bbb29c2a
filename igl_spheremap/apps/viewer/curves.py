"""Curves of a run in a window: what is minimised, and the number of folded faces, over the iterations."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ...draw import palette
from ...draw.plot import extremes
from ...mesh.arrays import FloatArray, IntArray
from ...result.recording import linear_below, objective, round_starts
from ...result.run import Step
from .window import imgui, implot

#: Pixels of a plot above and below its curve, and between two numbers at its axis.
_AROUND, _BETWEEN = 56.0, 18.0
#: Pixels around a plot: half of the last number below it stands there.
_PADDING = (24.0, 8.0)
#: Pixels between two numbers below a curve.
_ASIDE = 60.0


def energy_plot(history: Sequence[Step], shown: int, size: tuple[float, float]) -> float | None:
    """Plot what is minimised over the iterations, with its sign; the place at which it is pressed."""
    at, values, name = objective(history)
    linear, powers, scale, unit = linear_below(values), 10.0 ** np.arange(-18.0, 19.0), None, 1.0
    if linear == 0:
        values = np.where(values > 0, values, np.nan)
        scale = implot.ImPlotScale_Log10, _log, powers
    elif np.isfinite(linear):
        unit = 10.0 ** np.ceil(np.log10(linear))  # so that round numbers stand at the axis
        scale = implot.ImPlotScale_SymLog, _symlog, np.append(0.0, np.column_stack((powers, -powers)))
    return _curve(name, at, values / unit, history, shown, size, scale, unit=unit)


def folding_plot(history: Sequence[Step], foldings: IntArray, shown: int, size: tuple[float, float]) -> float | None:
    """Plot the number of folded faces over the iterations; the place at which it is pressed."""
    at, values = np.arange(len(foldings)), foldings.astype(np.float64)
    scale = implot.ImPlotScale_SymLog, _symlog, np.append(0.0, 10.0 ** np.arange(8))
    return _curve("folded faces", at, values, history, shown, size, scale, zero=True, colour=palette.FOLDED)


def _log(values: FloatArray) -> FloatArray:
    return np.asarray(np.log10(values))


def _symlog(values: FloatArray) -> FloatArray:
    """Where ImPlot's axis of that name has values."""
    return np.asarray(2 * np.arcsinh(values / 2))


def _ticks(candidates: FloatArray, places: FloatArray, shown: FloatArray, room: float) -> FloatArray:
    """Candidates, the first ones first, whose places among those `shown` on an axis are far enough apart for text."""
    low, high = shown.min(), max(shown.max(), shown.min() + 1e-12)
    chosen: list[int] = []
    pixels = (places - low) / (high - low) * room
    for k in np.flatnonzero((places >= low) & (places <= high)):
        if all(abs(pixels[k] - pixels[other]) >= _BETWEEN for other in chosen):
            chosen.append(int(k))
    return candidates[sorted(chosen)]


def _whole(last: int, room: float) -> list[int]:
    """Whole numbers from 0 to the last, a round number apart, of which no two are too close for text."""
    least = last * _ASIDE / room
    apart = next(size * ten for ten in 10 ** np.arange(18) for size in (1, 2, 5) if size * ten >= least)
    return list(range(0, last + 1, int(apart)))


def _curve(
    title: str,
    x: IntArray,
    y: FloatArray,
    history: Sequence[Step],
    shown: int,
    size: tuple[float, float],
    scale: tuple[int, Callable[[FloatArray], FloatArray], FloatArray] | None = None,
    *,
    unit: float = 1.0,
    zero: bool = False,
    colour: palette.Colour = palette.LINES[0],
) -> float | None:
    """A curve over a run, with a line at the iteration that is shown, to be dragged; where it is, while it is.

    The scale of the axis is linear, or one of ImPlot's, the function that it applies, and numbers to be written there,
    in the unit of the axis; `zero` keeps 0 in sight.
    """
    flags = implot.ImPlotFlags_NoLegend | implot.ImPlotFlags_NoMouseText | implot.ImPlotFlags_NoMenus
    plain = implot.ImPlotAxisFlags_NoLabel | implot.ImPlotAxisFlags_NoHighlight
    implot.PushStyleVar(implot.ImPlotStyleVar_PlotPadding, _PADDING)
    implot.PushStyleVar(implot.ImPlotStyleVar_PlotMinSize, _PADDING)
    if not implot.BeginPlot(title.replace("π", "pi"), size, flags | implot.ImPlotFlags_NoBoxSelect):
        implot.PopStyleVar(2)
        return None
    try:
        implot.SetupAxes("iteration", title, plain, plain | implot.ImPlotAxisFlags_AutoFit)
        last = max(len(history) - 1, 1)
        implot.SetupAxisLimits(implot.ImAxis_X1, 0, last, implot.ImPlotCond_Always)
        whole = _whole(last, size[0])
        implot.SetupAxisTicks(implot.ImAxis_X1, np.array(whole, dtype=np.float64), [f"{tick:,}" for tick in whole])
        good = np.flatnonzero(np.isfinite(y))
        if scale is not None and len(good):
            kind, function, candidates = scale
            implot.SetupAxisScale(implot.ImAxis_Y1, kind)
            places = function(np.append(y[good], 0.0) if zero else y[good])
            ticks = _ticks(candidates, function(candidates), places, size[1] - _AROUND)
            implot.SetupAxisTicks(implot.ImAxis_Y1, ticks, [f"{unit * tick:,.6g}" for tick in ticks])
        if len(good):
            chosen = good[extremes(y[good])]
            implot.SetNextLineStyle((*colour, 1.0), 1.5)
            implot.PlotLine(title, x[chosen].astype(np.float64), np.ascontiguousarray(y[chosen]))
            if zero:
                implot.SetNextLineStyle((0.0, 0.0, 0.0, 0.0), 1.0)
                implot.PlotLine("zero", x[[0, -1]].astype(np.float64), np.zeros(2))
            for k, stage in round_starts(history):
                implot.SetNextLineStyle((*palette.GUIDE, 1.0), 1.0)
                implot.PlotInfLines(f"##{k}", np.array([float(k)]))
                implot.Annotation(k, float(y[good].max()), (0.0, 0.0, 0.0, 0.0), (4.0, 0.0), True, stage)
        return _cursor(shown, last)
    finally:
        implot.EndPlot()
        implot.PopStyleVar(2)


def _cursor(shown: int, last: int) -> float | None:
    """A line at an iteration, with its number; where the mouse is that was pressed in the plot and is held."""
    if shown < 0:
        return None
    implot.DragLineX(0, float(shown), (*palette.INK, 0.8), 2.0, implot.ImPlotDragToolFlags_NoFit)
    implot.TagX(float(shown), (*palette.INK, 1.0), f"{shown:,}")
    (left, top), (width, height) = implot.GetPlotPos(), implot.GetPlotSize()
    pressed = np.subtract(imgui.GetMousePos(), imgui.GetMouseDragDelta(0, 0.0))
    inside = left <= pressed[0] <= left + width and top <= pressed[1] <= top + height
    if not (inside and imgui.IsMouseDown(0) and imgui.IsWindowFocused()):
        return None
    return float(np.clip(implot.GetPlotMousePos()[0], 0, last))
