"""Curves of a run in a window: the objective, and the number of folded faces, over the iterations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...draw import palette
from ...draw.plot import extremes
from ...draw.run import linear_below, objective, round_starts
from ...mesh.arrays import FloatArray, IntArray
from ...result.run import Step
from .window import imgui, implot

#: Pixels around a plot: half of the last number below it stands there.
_PADDING = (24.0, 8.0)


def energy_plot(history: Sequence[Step], shown: int, size: tuple[float, float]) -> float | None:
    """Plot the objective over the iterations, with its sign; return the iteration at which it is pressed."""
    at, values, name = objective(history)
    linear, sizes = linear_below(values), np.abs(values[values != 0])
    unit = linear
    if linear == 0:
        unit = float(sizes.min())
    elif linear == np.inf:
        unit = float(sizes.max(initial=1e-300))
    return _curve(name, at, values, unit, history, shown, size, palette.LINES[0])


def folding_plot(
    history: Sequence[Step], foldings: IntArray, shown: int, size: tuple[float, float]
) -> float | None:
    """Plot the number of folded faces over the iterations; return the iteration at which it is pressed."""
    return _curve(
        "folded faces",
        np.arange(len(foldings)),
        foldings,
        1.0,
        history,
        shown,
        size,
        palette.FOLDED,
    )


def _curve(
    title: str, x: IntArray, y: FloatArray | IntArray, unit: float, history: Sequence[Step], shown: int,
    size: tuple[float, float], colour: palette.Colour,
) -> float | None:  # fmt: skip
    """A curve over a run, with a line at the iteration that is shown, to be dragged; where it is, while it is.

    Its axis is linear below the unit, and logarithmic above it.
    """
    places, last = np.arcsinh(y / unit), max(len(history) - 1, 1)
    low, high = min(places.min(initial=0.0), 0.0), max(places.max(initial=0.0), 1e-3)
    least, most = np.floor(np.log10([unit, np.abs(y).max(initial=unit)]))
    powers = 10.0 ** np.arange(least, most + 1)
    ticks = _apart(
        np.concatenate(([0.0], *zip(powers, -powers, strict=True))),
        unit,
        (low, high),
        size[1] - 56.0,  # of the title and of the numbers
    )
    whole = _whole(last, size[0])
    implot.PushStyleVar(implot.ImPlotStyleVar_PlotPadding, _PADDING)
    implot.PushStyleVar(implot.ImPlotStyleVar_PlotMinSize, _PADDING)
    flags = (
        implot.ImPlotFlags_NoLegend | implot.ImPlotFlags_NoMouseText | implot.ImPlotFlags_NoMenus
    )
    try:
        if not implot.BeginPlot(
            f"{title.replace('π', 'pi')}, by iterate", size, flags | implot.ImPlotFlags_NoBoxSelect
        ):
            return None
        plain = implot.ImPlotAxisFlags_NoLabel | implot.ImPlotAxisFlags_NoHighlight
        implot.SetupAxes("iteration", title, plain, plain)
        margin = 0.05 * (high - low)
        implot.SetupAxesLimits(0, last, low - margin, high + margin, implot.ImPlotCond_Always)
        implot.SetupAxisTicks(
            implot.ImAxis_X1, np.array(whole, dtype=np.float64), [f"{tick:,}" for tick in whole]
        )
        implot.SetupAxisTicks(
            implot.ImAxis_Y1, np.arcsinh(ticks / unit), [f"{tick:,.6g}" for tick in ticks]
        )
        drawn = extremes(places)
        implot.SetNextLineStyle((*colour, 1.0), 1.5)
        implot.PlotLine(title, x[drawn].astype(np.float64), places[drawn])
        for k, stage in round_starts(history):
            implot.SetNextLineStyle((*palette.GUIDE, 1.0), 1.0)
            implot.PlotInfLines(f"##{k}", np.array([float(k)]))
            implot.Annotation(k, high, (0.0, 0.0, 0.0, 0.0), (4.0, 0.0), True, stage)
        pressed = _cursor(shown, last)
        implot.EndPlot()
        return pressed
    finally:
        implot.PopStyleVar(2)


def _apart(
    values: FloatArray,
    unit: float,
    ends: tuple[float, float],
    room: float,
    pixels: float = 18.0,
) -> FloatArray:
    """The values that lie on an axis and are far enough apart for text; earlier ones are preferred."""
    places = np.arcsinh(values / unit)
    chosen: list[int] = []
    for k in np.flatnonzero((places >= ends[0]) & (places <= ends[1])):
        if all(
            abs(places[k] - places[other]) / (ends[1] - ends[0]) * room >= pixels
            for other in chosen
        ):
            chosen.append(int(k))
    return values[chosen]


def _whole(last: int, room: float, pixels: float = 60.0) -> list[int]:
    """Whole numbers from 0 to the last, a round number apart, no two too close for text."""
    least = last * pixels / room
    apart = next(
        size * ten for ten in 10 ** np.arange(18) for size in (1, 2, 5) if size * ten >= least
    )
    return list(range(0, last + 1, int(apart)))


def _cursor(shown: int, last: int) -> float | None:
    """A line at an iteration, with its number; where it is dragged, or where the plot is pressed."""
    if shown < 0:
        return None
    dragged, place = implot.DragLineX(
        0, float(shown), (*palette.INK, 0.8), 2.0, implot.ImPlotDragToolFlags_NoFit
    )
    implot.TagX(float(shown), (*palette.INK, 1.0), f"{shown:,}")
    if not dragged:
        if not (implot.IsPlotHovered() and imgui.IsMouseDown(0)):
            return None
        place = implot.GetPlotMousePos()[0]
    return float(np.clip(place, 0, last))
