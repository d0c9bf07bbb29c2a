"""What a run went through, kept by a listener, so that whoever shows it never runs it again; and its curves."""

from __future__ import annotations

import itertools
import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..draw.palette import FOLDED, GUIDE, INK, LINES
from ..draw.plot import SMALL, new_figure, plot_angles
from ..mesh.arrays import FloatArray, IntArray
from ..verify.signs import folded_faces
from .run import History, Iterate, Step

#: Bytes of positions that a recording holds by default.
BUDGET = 400_000_000


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

    Where the positions outgrow the budget every second one is dropped, and from then on only every second
    (fourth, ...) one kept: the run stays evenly covered. The first and the last iterate of each stage are
    never dropped. It may be read from another thread while the run goes on.

    Parameters
    ----------
    f : (m, 3) int64 array
        Faces, to count foldings.
    budget : int
        Bytes of positions to hold at the most, the ends of stages not counted.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=500)
    >>> recording = Recording(f)
    >>> result = ism.spherical_conformal_map(v, f, listener=recording)
    >>> len(recording.frames) == len(result.history) == len(recording.foldings)
    True
    """

    def __init__(self, f: IntArray, budget: int = BUDGET) -> None:
        super().__init__()
        self._f = f
        self._budget = budget
        self._stride = 1
        self._lock = threading.Lock()
        self._frames: list[Frame] = []
        self._foldings: list[int] = []

    def __call__(self, iterate: Iterate) -> None:
        """Keep the iterate."""
        folded = folded_faces(iterate.x, self._f)
        with self._lock:
            frame = Frame(len(self.steps), iterate, int(folded.sum()), np.packbits(folded))
            super().__call__(iterate)
            self._foldings.append(frame.foldings)
            if len(self._frames) > 1 and not self._stays(len(self._frames) - 1, frame):
                self._frames.pop()  # it was kept only while it was the latest
            self._frames.append(frame)
            while self._stride < len(self.steps) and len(self._frames) * iterate.x.nbytes > self._budget:
                self._thin()

    def skip(self, step: Step) -> None:
        """Count an iterate whose positions are not at hand; its foldings are taken to be those before it."""
        with self._lock:
            self.steps.append(step)
            self._foldings.append(self._foldings[-1] if self._foldings else 0)

    def __repr__(self) -> str:
        return f"Recording({len(self._frames)} of {len(self.steps)} iterates)"

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

    def _thin(self) -> None:
        """Drop every second frame that is neither the first nor the last of its stage."""
        self._stride *= 2
        following = [*self._frames[1:], None]
        self._frames = [
            frame
            for k, (frame, after) in enumerate(zip(self._frames, following, strict=True))
            if after is None or self._stays(k, after)
        ]

    def _stays(self, k: int, after: Frame) -> bool:
        """True if the k-th frame is on the stride, or begins or ends its stage."""
        frame = self._frames[k]
        ends = _stage(after) != _stage(frame)
        begins = k == 0 or _stage(self._frames[k - 1]) != _stage(frame)
        return frame.index % self._stride == 0 or begins or ends


def _stage(frame: Frame) -> tuple[str, int]:
    return frame.iterate.stage, frame.iterate.round


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
                fontsize=SMALL,
                color=INK,
                rotation=90,
                ha="right",
                va="top",
            )
