"""A listener that keeps the iterates of a run, so that nothing is run twice to be shown; and plots of a run."""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..draw.palette import FOLDED, GUIDE, INK, LINES
from ..draw.plot import SMALL, extremes, new_figure, plot_angles, plot_areas
from ..errors import check_number
from ..mesh.arrays import FloatArray, IntArray
from ..verify.signs import folded_faces
from .run import History, Iterate, Step, iterations_in

#: Bytes of positions that a recording holds by default: 400 iterates of 40,000 vertices.
BUDGET = 400_000_000
#: Iterates on each side of the beginning of a stage that are never dropped: the step that leads there and the next one.
_AROUND = 2
#: Stages that minimise another energy than the one before them.
_OWN_ENERGY = ("opening", "balance")
#: Energies that end nearer to 4 pi than this are plotted less 4 pi: the harmonic energy, with or without landmarks.
_NEAR_4_PI = 1.0
#: Values in a wider ratio than this need a logarithmic axis.
_WIDE = 30.0
#: Axes of counts up to this have a tick for each number.
_FEW = 9


@dataclass(frozen=True, eq=False)
class Frame:
    """An iterate that a `Recording` kept.

    Attributes
    ----------
    index : int
        Its place among all iterates of the run.
    iterate : Iterate
        The iterate.
    foldings : int
        Number of its faces that are flipped or degenerate.
    packed : uint8 array
        These faces as bits, eight to a byte; ``folded`` has their indices.
    """

    index: int
    iterate: Iterate
    foldings: int
    packed: NDArray[np.uint8]

    def __repr__(self) -> str:
        return f"Frame({self.index}: {self.iterate}, {self.foldings} foldings)"

    @property
    def folded(self) -> IntArray:
        """Indices of the faces that are flipped or degenerate."""
        return np.flatnonzero(np.unpackbits(self.packed))


class Recording(History):
    """Listener that keeps the numbers of every iterate, and as many positions as its budget holds.

    Where the positions outgrow the budget, neighbours are kept in pairs, so that steps can still be seen before and
    after: every second (fourth, ...) pair, and all where the number of foldings changes, until these alone outgrow the
    budget. The first and the last two iterates of each stage are never dropped. It may be read from another thread
    while the run goes on.

    Parameters
    ----------
    f : (m, 3) int64 array
        Faces, to count foldings.
    budget : int
        Bytes of positions to hold; the ends of stages are kept even beyond it.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=500)
    >>> recording = ism.Recording(f)
    >>> result = ism.spherical_conformal_map(v, f, listener=recording)
    >>> len(recording.frames) == len(result.history) == len(recording.foldings)
    True
    """

    def __init__(self, f: IntArray, *, budget: int = BUDGET) -> None:
        super().__init__()
        self._f = f
        self._budget = check_number(budget, "budget")
        #: Of so many iterates two are kept; the first number is for where the count of foldings stays, the second for
        #: where it changes.
        self._strides = [2, 2]
        self._lock = threading.Lock()
        self._frames: list[Frame] = []
        self._foldings: list[int] = []

    def __call__(self, iterate: Iterate) -> None:
        """Keep the iterate."""
        folded = folded_faces(iterate.x, self._f)
        with self._lock:
            self._frames.append(
                Frame(len(self.steps), iterate, int(folded.sum()), np.packbits(folded))
            )
            super().__call__(iterate)
            self._foldings.append(self._frames[-1].foldings)
            if len(self._frames) > _AROUND and not self._stays(self._frames[-1 - _AROUND]):
                del self._frames[-1 - _AROUND]  # it was kept only while it was among the latest
            self._thin()

    def __repr__(self) -> str:
        return f"Recording({len(self._frames)} of {len(self.steps)} iterates)"

    def describe(self) -> str:
        """What is kept and what it takes, in words.

        Returns
        -------
        str
            A sentence.
        """
        with self._lock:
            kept, steps, used = len(self._frames), len(self.steps), self._nbytes() / 1e6
            if kept == steps:
                return f"every iterate is kept: {used:,.{int(used < 10)}f} of {self._budget / 1e6:,g} MB"
            others, changes = (
                f"1 in {stride // 2:,}" if stride > 2 else "all" for stride in self._strides
            )
            return (
                f"{kept:,} of {steps:,} iterates are kept: {changes} where foldings change, {others} elsewhere; "
                f"{used / kept * steps + 1:,.0f} MB would keep all"
            )

    @property
    def frames(self) -> tuple[Frame, ...]:
        """The iterates that were kept, in order; the latest is always among them."""
        with self._lock:
            return tuple(self._frames)

    @property
    def history(self) -> tuple[Step, ...]:
        """The numbers of every iterate."""
        with self._lock:
            return tuple(self.steps)

    @property
    def foldings(self) -> IntArray:
        """Folded faces of every iterate, (k,) int64."""
        with self._lock:
            return np.array(self._foldings, dtype=np.int64)

    def _nbytes(self) -> int:
        return sum(frame.iterate.x.nbytes for frame in self._frames[:1]) * len(self._frames)

    def _thin(self) -> None:
        """Drop pairs until the budget holds the others: the last are those at which the number of foldings changes."""
        while self._nbytes() > self._budget and min(self._strides) < len(self.steps):
            changing = self._strides[0] >= len(self.steps)  # no others are left
            self._strides[changing] *= 2
            self._frames = [frame for frame in self._frames if self._stays(frame)]

    def _stays(self, frame: Frame) -> bool:
        """True if it is one of a pair that is kept, or beside the beginning or the end of a stage."""
        k, last = frame.index, len(self.steps) - 1
        if (
            k < _AROUND
            or k > last - _AROUND
            or _stage(self.steps[k - _AROUND]) != _stage(self.steps[k + _AROUND])
        ):
            return True
        changes = not self._foldings[k - 1] == self._foldings[k] == self._foldings[k + 1]
        return k % self._strides[changes] < 2


def _stage(step: Step) -> tuple[str, int]:
    return step.stage, step.round


def plot_run(
    history: Sequence[Step],
    foldings: ArrayLike | None,
    differences: FloatArray,
    ratios: FloatArray,
    *,
    title: str = "",
) -> Any:
    """Plot energy and folded faces of every iterate, and what the result does to angles and areas.

    It takes angle differences (m, 3) in degrees and logarithms of area ratios (m,). A sentence stands in place of a
    curve of two points, or of zeros; without foldings there is none of them. Lai et al., Figs. 4 and 10.
    """
    at, values, name = objective(history)
    counts = None if foldings is None else np.asarray(foldings)
    said = []
    if curved := len(values) > 2:
        said.append(iterations_in(sum(step.iteration > 0 for step in history)))
    elif len(values):
        said.append(f"{name}: {' to '.join(f'{value:.3g}' for value in values)}")
    if counts is not None and not counts.any():
        said.append("no face is folded in any iterate")
        counts = None
    columns = curved + (counts is not None)
    shape = (2, 2) if columns == 2 else (1, columns + 2)  # four in a row would be small
    figure, axes = new_figure(*shape, "\n".join(filter(None, (title, "; ".join(said)))), (3.6, 3.0))
    *curves, angles, areas = axes.ravel()
    if curved:
        energy = curves[0]
        drawn = extremes(values)
        energy.plot(at[drawn], values[drawn], color=LINES[0], marker=_marker(values))
        linear = linear_below(values)
        if np.isfinite(linear):
            energy.set_yscale(
                *(("symlog",) if linear else ("log",)), **({"linthresh": linear} if linear else {})
            )
        energy.set_title(name, fontsize=SMALL + 1)
    if counts is not None:
        most = counts.max()
        drawn = extremes(counts)
        curves[-1].plot(drawn, counts[drawn], color=FOLDED, marker=_marker(counts))
        if most > _FEW:
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


def objective(history: Sequence[Step]) -> tuple[IntArray, FloatArray, str]:
    """Places in the history, values and name of what was minimised last.

    It is the harmonic energy minus 4 pi, its value for a smooth conformal map; or another energy minus its minimum.

    >>> at, values, name = objective([Step("harmonic", 0, 0, 13.0, 0.0, 0.0), Step("balance", 0, 0, 5.0, 0.0, 0.0),
    ...                               Step("balance", 0, 1, 3.0, 0.0, 0.0)])
    >>> at.tolist(), values.tolist(), name
    ([1, 2], [2.0, 0.0], 'energy of the balance above its minimum')
    """
    kinds = [step.stage if step.stage in _OWN_ENERGY else "" for step in history]
    same = [
        k for k, kind in enumerate(kinds) if kind == kinds[-1] and math.isfinite(history[k].energy)
    ]
    at, energies = np.array(same, dtype=np.int64), np.array([history[k].energy for k in same])
    if not same:
        return at, energies, "energy"
    least = float(energies.min())
    if not kinds[-1] and abs(least - 4 * math.pi) < _NEAR_4_PI:
        return at, energies - 4 * math.pi, "energy minus 4π"
    return (
        at,
        energies - least,
        f"energy{f' of the {kinds[-1]}' if kinds[-1] else ''} above its minimum",
    )


def linear_below(values: FloatArray) -> float:
    """Size of values below which an axis that shows all of them is linear, and logarithmic beyond.

    0 where a logarithmic axis serves; infinity where a linear one does.

    >>> [linear_below(np.array(values)) for values in ([200.0, 1e-3], [2e-3, -1e-3], [9.0, -0.01])]
    [0.0, inf, 0.01]
    """
    above, below = max(float(values.max(initial=0)), 0.0), max(-float(values.min(initial=0)), 0.0)
    if below:
        return below if above > _WIDE * below else math.inf
    positive = values[values > 0]
    return 0.0 if len(positive) > 1 and above > _WIDE * float(positive.min()) else math.inf


def _marker(values: NDArray[Any]) -> str | None:
    return "." if len(values) < 30 else None


def round_starts(history: Sequence[Step]) -> list[tuple[int, str]]:
    """Places in the history where a round of Algorithm 2 begins, and the stage that begins it."""
    return [
        (k, step.stage) for k, step in enumerate(history) if k and step.round > history[k - 1].round
    ]


def _mark_rounds(ax: Any, history: Sequence[Step]) -> None:
    """A line where each round begins."""
    for k, stage in round_starts(history):
        ax.axvline(k, color=GUIDE, linestyle=":", linewidth=1)
        ax.annotate(stage, (k, 1), xycoords=("data", "axes fraction"), fontsize=SMALL, color=INK, rotation=90,
                    ha="left", va="top")  # fmt: skip
