"""The curves of a run by matplotlib: energy, foldings, angle differences."""

from __future__ import annotations

import io
import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import import_optional

if TYPE_CHECKING:
    from ..descent.iterate import Step

FloatArray = NDArray[np.float64]

#: What a figure can be saved as.
FORMATS = (".png", ".svg", ".pdf")
_BLUE, _VERMILION, _GREY = "#0072B2", "#D63D00", "#9AA3AC"


def plot_run(history: Sequence[Step], foldings: ArrayLike | None, differences: FloatArray, *, title: str = "") -> Any:
    """Plot what a run went through.

    Parameters
    ----------
    history : sequence of Step
        Every iterate.
    foldings : (k,) array_like, optional
        Folded faces of every iterate; without them that plot is left out.
    differences : (m, 3) float64 array
        Angle differences of the result in degrees.
    title : str
        Over all.

    Returns
    -------
    matplotlib.figure.Figure
        Not shown, and known to no window system.

    Raises
    ------
    FileError
        If matplotlib is not installed.

    References
    ----------
    Lai et al., Figs. 4 and 10.
    """
    figure_module = import_optional("matplotlib.figure", "a plot", "plot")
    count = 2 if foldings is None else 3
    # Notebooks show a bare figure only after pyplot was imported there, but anything with this method at once.
    shown = type("Figure", (figure_module.Figure,), {"_repr_png_": _png})
    figure = shown(figsize=(4 * count, 3.2), layout="constrained")
    axes = list(figure.subplots(1, count))
    _energy(axes[0], history)
    if foldings is not None:
        _foldings(axes[1], history, np.asarray(foldings))
    _histogram(axes[-1], differences)
    for ax in axes:
        ax.spines[["top", "right"]].set_visible(False)
        ax.title.set_fontsize(11)
    figure.suptitle(title, fontsize=12)
    return figure


def _png(figure: Any) -> bytes:
    """The figure as a PNG file."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=100)
    return stream.getvalue()


def _energy(ax: Any, history: Sequence[Step]) -> None:
    gap = np.abs(np.array([step.energy for step in history]) - 4 * math.pi)
    ax.semilogy(np.maximum(gap, 1e-16), color=_BLUE, marker="." if len(gap) < 30 else None)
    ax.set(title="harmonic energy above 4 pi", xlabel="iterate")
    _mark_rounds(ax, history)


def _foldings(ax: Any, history: Sequence[Step], foldings: NDArray[np.int64]) -> None:
    ax.plot(foldings, color=_VERMILION, marker="." if len(foldings) < 30 else None)
    ax.set_yscale("symlog", linthresh=1)
    ax.set_ylim(bottom=-0.2)
    ax.set(title="folded faces", xlabel="iterate")
    _mark_rounds(ax, history)


def _mark_rounds(ax: Any, history: Sequence[Step]) -> None:
    """A line where each round of Algorithm 2 begins."""
    for k, (before, after) in enumerate(itertools.pairwise(history)):
        if after.round > before.round:
            ax.axvline(k + 1, color=_GREY, linestyle=":", linewidth=1)
            ax.annotate(
                after.stage,
                (k + 1, 1),
                xycoords=("data", "axes fraction"),
                fontsize=8,
                color="#5A636C",
                rotation=90,
                ha="right",
                va="top",
            )


def _histogram(ax: Any, differences: FloatArray) -> None:
    values = differences.ravel()
    size = np.abs(values)
    reach = max(1.0, float(np.percentile(size, 99.5)))
    ax.hist(values, bins=61, range=(-reach, reach), color=_BLUE)
    ax.set(
        title=f"angle differences, mean size {size.mean():.3g} degrees",
        xlabel="degrees, image minus source",
        yticks=[],
    )
    ax.text(
        0.98,
        0.95,
        f"99% below {np.percentile(size, 99):.3g}\nlargest {size.max():.3g}",
        ha="right",
        va="top",
        transform=ax.transAxes,
        fontsize=8,
    )
