"""Figures by matplotlib: the curves of a run, and angle differences."""

from __future__ import annotations

import io
import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..descent.iterate import Step
from ..errors import import_optional
from ..mesh.arrays import FloatArray
from .palette import FOLDED, GUIDE, INK, LINES

#: What a figure can be saved as.
FORMATS = (".png", ".svg", ".pdf")
_SMALL = 8  # points
_BINS = 81


def new_figure(rows: int, columns: int, title: str, size: tuple[float, float] = (3.2, 3.4)) -> tuple[Any, Any]:
    """A matplotlib figure without pyplot, which opens no window, and its axes (rows, columns) of `size` in inches."""
    base = import_optional("matplotlib.figure", "a figure", "plot").Figure
    # Notebooks show a bare figure only after pyplot was imported there, but anything with this method at once.
    shown = type("Figure", (base,), {"_repr_png_": _png})
    figure = shown(figsize=(size[0] * columns, size[1] * rows), layout="constrained", dpi=150)
    figure.suptitle(title, fontsize=11)
    axes = figure.subplots(rows, columns, squeeze=False)
    for ax in axes.ravel():
        ax.spines[["top", "right"]].set_visible(False)
    return figure, axes


def _png(figure: Any) -> bytes:
    """The figure as a PNG file."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=100)
    return stream.getvalue()


def plot_run(history: Sequence[Step], foldings: ArrayLike | None, differences: FloatArray, *, title: str = "") -> Any:
    """Plot energy and folded faces of every iterate, and the angle differences (m, 3) of the result in degrees.

    Without foldings that plot is left out. Lai et al., Figs. 4 and 10.
    """
    figure, ((energy, *middle, angles),) = new_figure(1, 2 if foldings is None else 3, title, (4, 3.2))
    gap = np.abs(np.array([step.energy for step in history]) - 4 * math.pi)
    energy.semilogy(np.maximum(gap, 1e-16), color=LINES[0], marker=_marker(gap))
    energy.set(title="harmonic energy above 4π", xlabel="iterate")
    for ax in middle:
        counts = np.asarray(foldings)
        ax.plot(counts, color=FOLDED, marker=_marker(counts))
        ax.set_yscale("symlog", linthresh=1)
        ax.set_ylim(bottom=-0.2)
        ax.set(title="folded faces", xlabel="iterate")
    for ax in (energy, *middle):
        _mark_rounds(ax, history)
    plot_angles(angles, differences)
    return figure


def _marker(values: NDArray[Any]) -> str | None:
    return "." if len(values) < 30 else None


def _mark_rounds(ax: Any, history: Sequence[Step]) -> None:
    """A line where each round of Algorithm 2 begins."""
    for k, (before, after) in enumerate(itertools.pairwise(history)):
        if after.round > before.round:
            ax.axvline(k + 1, color=GUIDE, linestyle=":", linewidth=1)
            ax.annotate(
                after.stage,
                (k + 1, 1),
                xycoords=("data", "axes fraction"),
                fontsize=_SMALL,
                color=INK,
                rotation=90,
                ha="right",
                va="top",
            )


def plot_angles(ax: Any, differences: FloatArray, reach: float | None = None) -> None:
    """Histogram of angle differences up to `reach` degrees; by default it leaves 0.5 percent to the end bins."""
    size = np.abs(differences)
    if reach is None:
        reach = max(1.0, float(np.percentile(size, 99.5)))
    edges, share = angle_histogram(differences, reach)
    ax.stairs(share, edges, fill=True, color=LINES[0])
    ax.set(yticks=[])
    ax.set_xlabel("degrees, image minus source (ends hold the rest)", fontsize=_SMALL)
    ax.set_title(
        f"angle differences: mean size {size.mean():.3g},\n"
        f"99% below {np.percentile(size, 99):.3g}, largest {size.max():.3g} degrees",
        fontsize=_SMALL,
    )


def angle_histogram(differences: FloatArray, reach: float) -> tuple[FloatArray, FloatArray]:
    """Edges of bins from `-reach` to `reach` degrees, and the share of the differences in each.

    The first and the last bin also hold what is beyond.

    >>> edges, share = angle_histogram(np.array([[0.0, 0.0, 90.0]]), 40.0)
    >>> edges[[0, -1]].tolist(), share[[40, -1]].round(3).tolist()
    ([-40.0, 40.0], [0.667, 0.333])
    """
    counts, edges = np.histogram(np.clip(differences, -reach, reach), bins=_BINS, range=(-reach, reach))
    return edges, counts / differences.size
