"""Listeners that keep what a run went through, so that whoever shows it never runs it again."""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..mesh.arrays import IntArray
from ..verify.signs import folded_faces
from .iterate import Iterate, Listener, Step

#: Bytes of positions that a recording holds by default.
BUDGET = 400_000_000


@dataclass(frozen=True, eq=False)
class Frame:
    """An iterate that was kept, its place among all iterates of the run, and its folded faces, eight to a byte."""

    index: int
    iterate: Iterate
    foldings: int
    packed: NDArray[np.uint8]

    @property
    def folded(self) -> IntArray:
        """Indices of the faces that are flipped or degenerate."""
        return np.flatnonzero(np.unpackbits(self.packed))


class History:
    """Listener that keeps the numbers of every iterate, and passes the iterate on to the next listener."""

    def __init__(self, listener: Listener | None = None) -> None:
        self.steps: list[Step] = []
        self._listener = listener

    def __call__(self, iterate: Iterate) -> None:
        self.steps.append(iterate.step)
        if self._listener is not None:
            self._listener(iterate)


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
