"""A map that is computed in a process of its own, so that drawing does not slow it, as a sequence of slides."""

from __future__ import annotations

import multiprocessing
import queue
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from multiprocessing.synchronize import Event
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...descent.iterate import Iterate, Step, title_of
from ...maps.options import Method
from ...maps.sphere_map import SphereMap
from ...maps.spherical_conformal_map import spherical_conformal_map
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import Mesh, check_mesh
from ...mesh.measure import vertex_normals
from ...verify.signs import folded_faces

#: The start of the paper's algorithms; shown first in every run, for comparison.
GAUSS_MAP = Step("gauss map", 0, 0, float("nan"), float("nan"), 0.0)


@dataclass(frozen=True, eq=False)
class Slide:
    """A map of a run: its place among all iterates, its numbers, positions and folded faces, eight to a byte."""

    index: int
    step: Step
    title: str
    x: FloatArray
    foldings: int
    packed: NDArray[np.uint8]

    @classmethod
    def of(cls, index: int, step: Step, x: FloatArray, f: IntArray, title: str = "") -> Slide:
        folded = folded_faces(x, f)
        return cls(index, step, title or title_of(step), x, int(folded.sum()), np.packbits(folded))

    @property
    def folded(self) -> IntArray:
        """Indices of the faces that are flipped or degenerate."""
        return np.flatnonzero(np.unpackbits(self.packed))

    def facts(self) -> dict[str, str | int]:
        """What a picture of it shows, for JSON."""
        return {
            "title": self.title,
            "stage": self.step.stage,
            "round": self.step.round,
            "iteration": self.step.iteration,
            "foldings": self.foldings,
        }


def stops(slides: Sequence[Slide]) -> list[tuple[str, int]]:
    """Names and indices of the start, of the slides at star maps and repairs, and of the end."""
    marks = [(slides[0].title, 0)]
    for k, slide in enumerate(slides[:-1]):
        again = f" {slide.step.round}" if slide.step.round > 1 else ""
        if slide.step.stage == "star map":
            marks += [(f"before the star map{again}", k - 1), (f"after the star map{again}", k)]
        elif slide.step.stage == "repair":
            marks.append((f"repair{again}", k))
    return [*marks, ("end", len(slides) - 1)]


def thin(slides: Sequence[Slide], room: int) -> list[Slide]:
    """The first and last slide of each stage, and about `room` others: most where the foldings change most."""
    stages = [stage_of(slide.step) for slide in slides]
    neighbours = zip([None, *stages], stages, [*stages[1:], None], strict=False)
    ends = [k for k, (before, own, after) in enumerate(neighbours) if not before == own == after]
    foldings = np.log1p([slide.foldings for slide in slides])
    change = np.abs(np.diff(foldings, prepend=foldings[:1]))
    # half of the room for even coverage, half for changes
    place = np.cumsum(change / max(change.sum(), 1e-300) + 1 / len(slides))
    chosen = np.searchsorted(place, np.linspace(0, place[-1], room)).clip(0, len(slides) - 1)
    return [slides[k] for k in np.union1d(chosen, ends)]


def stage_of(step: Step | Iterate) -> tuple[str, int]:
    """What stays the same until a stage ends."""
    return step.stage, step.round


Source = tuple[FloatArray, IntArray]

#: Bytes of positions that a run keeps.
BUDGET = 400_000_000
#: Iterates on their way between the processes.
_IN_TRANSIT = 32
#: Bytes of positions that a live run sends in a second: what is drawn grows with the mesh as they do.
_BYTES_PER_SECOND = 5_000_000
#: A stage may begin with the last map of the one before, up to rounding; it is shown once.
_SAME = 1e-9


class Run:
    """Load a mesh and map it; `poll` takes over what has come of it so far.

    >>> from functools import partial
    >>> import igl_spheremap as ism
    >>> run = Run(partial(ism.samples.make, "spheroid", n_vertices=500), "auto")
    >>> run.wait()
    >>> run.result.certificate.folding_free, run.slides[0].title, run.slides[-1].title
    (True, 'Gauss map', 'Result: certified folding-free')
    """

    def __init__(
        self, load: Callable[[], Source], method: str | Method, *, live: bool = False, budget: int = BUDGET
    ) -> None:
        """`load` is sent to the process: it must be picklable.

        A live run does not wait until its iterates are taken over: it leaves out those that come too fast.
        """
        self.mesh: Mesh | None = None
        self.slides: list[Slide] = []
        self.result: SphereMap | None = None
        self.error: Exception | None = None
        self._budget = budget
        self.iterates = 0
        spawn = multiprocessing.get_context("spawn")  # a fork would share the OpenGL context
        self._stopped = spawn.Event()
        self._messages: multiprocessing.Queue[Any] = spawn.Queue(_IN_TRANSIT)
        work = (load, method, live, self._messages, self._stopped)
        self._process = spawn.Process(target=_work, args=work, daemon=True)
        self._process.start()

    @property
    def running(self) -> bool:
        """True until there is a result or an error."""
        return self.result is None and self.error is None

    def stop(self) -> None:
        """End at the next iterate, with what there is then."""
        self._stopped.set()

    def close(self) -> None:
        """End at once."""
        self._process.kill()
        self._process.join()

    def wait(self) -> None:
        """Until it is done."""
        while self.running:
            self.poll(seconds=1.0, wait=0.1)

    def poll(self, seconds: float, wait: float = 0.0) -> None:
        """Take over what has arrived, for so long at the most; the first message may be waited for."""
        until = time.monotonic() + seconds
        while self.running and time.monotonic() < until:
            alive = self._process.is_alive()  # before the queue is read, so that no last word is missed
            try:
                kind, content = self._messages.get(timeout=wait) if wait else self._messages.get_nowait()
            except queue.Empty:
                if not alive:
                    self.error = RuntimeError(f"the computation ended with exit code {self._process.exitcode}")
                return
            getattr(self, f"_take_{kind}")(content)

    def _take_mesh(self, source: Source) -> None:
        self.mesh = check_mesh(*source)

    def _take_iterates(self, content: tuple[list[Step], FloatArray]) -> None:
        steps, x = content
        assert self.mesh is not None
        if not self.slides and stage_of(steps[-1]) != stage_of(GAUSS_MAP):
            self.slides.append(Slide.of(0, GAUSS_MAP, vertex_normals(self.mesh.v, self.mesh.f), self.mesh.f))
        self.iterates += len(steps)
        if steps[-1].iteration == 0 and self.slides and np.abs(self.slides[-1].x - x).max() < _SAME:
            return
        self.slides.append(Slide.of(self.iterates - 1, steps[-1], x, self.mesh.f))
        room = max(8, self._budget // x.nbytes)
        if len(self.slides) > room:
            self.slides = thin(self.slides, room // 2)

    def _take_result(self, result: SphereMap) -> None:
        assert self.mesh is not None
        verdict = "certified folding-free" if result.certificate.folding_free else "not folding-free"
        last = self.slides[-1].step._replace(energy=result.energy)
        self.slides.append(Slide.of(self.iterates, last, result.sphere, self.mesh.f, f"Result: {verdict}"))
        self.result = result

    def _take_error(self, error: Exception) -> None:
        self.error = error


class _Sender:
    """Listener that sends iterates; of a live run the ends of each stage always, those between while there is time."""

    def __init__(self, live: bool, messages: multiprocessing.Queue[Any], stopped: Event) -> None:
        self._live, self._messages, self._stopped = live, messages, stopped
        self._steps: list[Step] = []
        self._unsent: Iterate | None = None
        self._stage: tuple[str, int] | None = None
        self._next = 0.0

    def __call__(self, iterate: Iterate) -> None:
        begins = self._stage != stage_of(iterate)
        if begins:
            self.flush()
        self._stage = stage_of(iterate)
        self._steps.append(iterate.step)
        self._unsent = iterate
        if begins or not self._live:
            self._send(block=True)
        elif time.monotonic() > self._next:
            self._send(block=False)
        if self._stopped.is_set():
            raise StopIteration

    def flush(self) -> None:
        """Send the last iterate if it is held back."""
        if self._unsent is not None:
            self._send(block=True)

    def _send(self, block: bool) -> None:
        assert self._unsent is not None
        try:
            self._messages.put(("iterates", (self._steps, self._unsent.x)), block=block)
        except queue.Full:
            return
        self._next = time.monotonic() + self._unsent.x.nbytes / _BYTES_PER_SECOND
        self._steps, self._unsent = [], None


def _work(
    load: Callable[[], Source], method: str | Method, live: bool, messages: Any, stopped: Event
) -> None:
    """The process: whatever happens, its last message is the result or the error."""
    try:
        v, f = load()
        check_mesh(v, f)
        messages.put(("mesh", (v, f)))
        sender = _Sender(live, messages, stopped)
        result = spherical_conformal_map(v, f, method, listener=sender)
        sender.flush()
        messages.put(("result", result))
    except Exception as error:  # shown in the window
        messages.put(("error", error))
