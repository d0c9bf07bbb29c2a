"""A listener that keeps the iterates of a run, so that nothing is run twice to be shown."""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import check_number
from ..mesh.arrays import IntArray
from ..verify.signs import folded_faces
from .run import History, Iterate, Step

#: Bytes of positions that a recording holds by default: 400 iterates of 40,000 vertices.
BUDGET = 400_000_000
#: Iterates on each side of a stage's beginning that are never dropped: the step there and the next one.
_AROUND = 2


@dataclass(frozen=True, eq=False)
class Frame:
    """An iterate that a `Recording` kept, with its place in the run and its folded faces, which no iterate knows.

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

    If the positions outgrow the budget, neighbours are kept in pairs, so that both sides of a step can still be seen.
    Every second (fourth, ...) pair is kept, and every pair that changes the number of foldings, until these alone
    outgrow the budget. The first and the last two iterates of each stage are never dropped. Another thread may read it
    during the run.

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
        #: Two iterates of each stride are kept: the first stride if the number of foldings stays, the second if it
        #: changes.
        self._stride = self._stride_at_changes = 2
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
        """Say how many iterates are kept, and how much memory they take.

        Returns
        -------
        str
            A sentence.
        """
        with self._lock:
            kept, steps, used = len(self._frames), len(self.steps), self._nbytes() / 1e6
            if kept == steps:
                taken = f"{used:,.0f}"
                if used < 10:
                    taken = f"{used:.1f}"
                return f"every iterate is kept: {taken} of {self._budget / 1e6:,g} MB"
            return (
                f"{kept:,} of {steps:,} iterates are kept: {_share(self._stride_at_changes)} where foldings change, "
                f"{_share(self._stride)} elsewhere; "
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
        steps = len(self.steps)
        while self._nbytes() > self._budget and self._stride_at_changes < steps:
            if self._stride < steps:
                self._stride *= 2
            else:  # no others are left
                self._stride_at_changes *= 2
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
        stride = self._stride_at_changes
        if self._foldings[k - 1] == self._foldings[k] == self._foldings[k + 1]:
            stride = self._stride
        return k % stride < 2


def _share(stride: int) -> str:
    """The number of kept iterates, two of each `stride`."""
    if stride == 2:
        return "all"
    return f"1 in {stride // 2:,}"


def _stage(step: Step) -> tuple[str, int]:
    return step.stage, step.round
