"""A map that is computed in a process of its own, so that drawing does not slow it, and the record of its run so
far."""

from __future__ import annotations

import contextlib
import itertools
import multiprocessing
import os
import queue
import signal
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from multiprocessing.context import SpawnProcess
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import Mesh, check_mesh
from ...mesh.measure import vertex_normals
from ...mesh_repair.repair_mesh import repair_mesh
from ...result.recording import BUDGET, Frame, Recording
from ...result.run import Iterate, Listener, Stage, Step, title_of

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

Source = tuple[FloatArray, IntArray]
#: Its kind, and its content.
Message = tuple[str, Any]


class Solve(Protocol):
    """Maps vertices and faces, and notifies a listener."""

    def __call__(self, v: FloatArray, f: IntArray, *, listener: Listener) -> SphereMap: ...


class ShownRun:
    """A run so far: the iterates that are kept, and sentences on them.

    `begin` has it computed in the background; `poll` takes over its results so far, into a `Recording`.

    >>> from functools import partial
    >>> import igl_spheremap as ism
    >>> run = ShownRun().begin(partial(ism.samples.make, "spheroid", n_vertices=500), ism.spherical_conformal_map)
    >>> run.wait()
    >>> run.result.certificate.folding_free, run.title(run.frames[0]), run.title(run.frames[-1])
    (True, 'Gauss map, iteration 0', 'Result: certified folding-free')
    """

    def __init__(self, budget: int = BUDGET) -> None:
        self.name = ""
        self.mesh: Mesh | None = None
        self.result: SphereMap | None = None
        self.error: Exception | None = None
        self.frames: tuple[Frame, ...] = ()
        #: Places of the frames that the next iteration follows, and their iterations.
        self.steps = self.iterations = np.empty(0, dtype=np.int64)
        self.foldings = self.changes = np.empty(0, dtype=np.int64)
        self.seconds = 0.0
        #: When it was begun, by the clock of `time.monotonic`.
        self.began = 0.0
        self._recording: Recording | None = None
        self._budget = budget
        #: The process that computes it, once it was begun.
        self.process: SpawnProcess | None = None

    def begin(
        self, load: Callable[[], Source], solve: Solve, repair: Mapping[str, Any] | None = None
    ) -> ShownRun:
        """Load a mesh and map it in a process of its own, to which both functions are sent: they must be picklable.

        With options of `repair_mesh` the mesh is repaired first.
        """
        spawn = multiprocessing.get_context("spawn")  # a fork would share the OpenGL context
        # No queue and no event: a killed process may hold a lock of these, or leave half a message, for which the
        # window would wait for ever. A pipe whose other end is theirs alone ends with the process.
        self._messages, messages = spawn.Pipe(duplex=False)
        stopped, self._stopped = spawn.Pipe(duplex=False)
        work = (load, repair, solve, messages, stopped)
        self.began = time.monotonic()
        self.process = spawn.Process(target=_work, args=work, daemon=True)
        # Ctrl-C is for the window, which ends the process
        handler = signal.signal(signal.SIGINT, signal.SIG_IGN)
        self.process.start()
        signal.signal(signal.SIGINT, handler)
        messages.close()
        stopped.close()
        return self

    def stop(self) -> None:
        """Ask the run to end at its next iterate, with the map so far."""
        with contextlib.suppress(OSError):  # it has ended
            self._stopped.send(None)

    def close(self) -> None:
        """End at once."""
        if self.process is not None:
            self.process.kill()
            self.process.join()

    def wait(
        self, progress: Callable[[ShownRun], None] = lambda run: None, turn: float = 0.3
    ) -> None:
        """Wait until it is done; `progress` is called with the run each time that `turn` seconds have passed."""
        while self.running:
            self.poll(turn, wait=turn / 3)
            progress(self)

    def poll(self, seconds: float, wait: float = 0.0) -> None:
        """Take over messages, for this many seconds at most, and wait up to `wait` seconds for one."""
        until = time.monotonic() + seconds
        while self.running and self.process is not None and time.monotonic() < until:
            try:
                if not self._messages.poll(wait):
                    break
                message = self._messages.recv()
            except (EOFError, OSError):  # behind the last message, or within one
                self.process.join()
                self.error = RuntimeError(
                    f"the computation ended with exit code {self.process.exitcode}"
                )
                break
            self._take(*message)
        self._count()

    @property
    def running(self) -> bool:
        """True until there is a result or an error."""
        return self.result is None and self.error is None

    @property
    def history(self) -> tuple[Step, ...]:
        """The numbers of every iterate so far, those included that are not kept."""
        if self._recording is None:
            return ()
        return self._recording.history

    @property
    def memory(self) -> str:
        """A sentence on which iterates are kept, and how much memory they take."""
        if self._recording is None:
            return ""
        return self._recording.describe()

    def title(self, frame: Frame) -> str:
        """The contents of a frame, in words."""
        if self.result is None or frame is not self.frames[-1]:
            return title_of(frame.iterate)
        if self.result.certificate.folding_free:
            return "Result: certified folding-free"
        return "Result: not folding-free"

    def stops(self) -> list[tuple[str, int]]:
        """Names and places of the start, of the frames at star maps and repairs, and of the end."""
        marks = [("Gauss map", 0)]
        for k, frame in enumerate(self.frames[:-1]):
            again = ""
            if frame.iterate.round > 1:
                again = f" {frame.iterate.round}"
            if frame.iterate.stage is Stage.STAR_MAP:
                marks += [(f"before the star map{again}", k - 1), (f"after the star map{again}", k)]
            elif frame.iterate.stage is Stage.REPAIR:
                marks.append((f"repair{again}", k))
        return [*marks, ("end", len(self.frames) - 1)]

    def beside(self, iteration: int, way: int) -> int:
        """The step this many iterations on, or the next one that was kept, or the last."""
        kept = self.iterations
        if not len(kept):
            return 0
        k = np.searchsorted(kept, iteration + way)
        if way < 0:
            k = np.searchsorted(kept, iteration + way, "right") - 1
        return int(kept[np.clip(k, 0, len(kept) - 1)])

    def change(self, iteration: int, way: int) -> int | None:
        """The next (way 1) or last (-1) step with a large change of foldings, or none."""
        after, before = (
            self.changes[self.changes > iteration],
            self.changes[self.changes < iteration],
        )
        if way > 0 and len(after):
            return int(after[0])
        if way < 0 and len(before):
            return int(before[-1])
        return None

    def _take(self, kind: str, content: Any) -> None:
        """Take over a message."""
        match kind:
            case "mesh":
                self.mesh = check_mesh(*content)
                self._recording = Recording(self.mesh.f, budget=self._budget)
            case "iterates":
                self._take_iterates(*content)
            case "result":
                self._take_result(content)
            case "error":
                self.error = content

    def _count(self) -> None:
        """Count the iterates taken over."""
        if self._recording is not None and len(self._recording.steps) > len(self.foldings):
            self.frames, self.foldings = self._recording.frames, self._recording.foldings
            places = np.array([frame.index for frame in self.frames])
            self.steps = np.flatnonzero(np.diff(places) == 1)
            self.iterations, self.changes = places[self.steps], changes(self.foldings)

    def _take_iterates(self, seconds: float, iterates: list[Iterate], same: float = 1e-9) -> None:
        """Record iterates; a stage may begin with the last map of the one before, up to rounding: it is shown once."""
        self.seconds = seconds
        assert self.mesh is not None
        assert self._recording is not None
        if not self._recording.steps and iterates[0].stage is not Stage.GAUSS_MAP:
            # The start of the paper's algorithms is shown first in every run, for comparison.
            self._recording(
                Iterate(
                    Stage.GAUSS_MAP, 0, 0, vertex_normals(self.mesh.unit, self.mesh.f), float("nan")
                )
            )
        for iterate in iterates:
            begins = iterate.iteration == 0 and len(self._recording.steps) > 0
            if not begins or np.abs(self._recording.frames[-1].iterate.x - iterate.x).max() >= same:
                self._recording(iterate)

    def _take_result(self, result: SphereMap) -> None:
        assert self._recording is not None
        place = Stage.RESULT, 0, 0  # of a result that was there already, as at balance 0
        if self._recording.steps:
            place = self._recording.steps[-1][:3]
        self._recording(Iterate(*place, result.sphere, result.energy))
        self.result = result


def changes(foldings: IntArray, most: int = 24) -> IntArray:
    """Find the steps after which 1 + foldings has changed by a factor since the last: 2, or a power of it.

    The power is the first with few enough steps: with more, one jump would lead hardly further.

    >>> changes(np.array([100, 90, 40, 45, 0, 0]))
    array([1, 3])
    """
    levels = np.log2(1.0 + foldings).tolist()
    tried = (_jumps(levels, octaves) for octaves in itertools.count(1))
    return np.array(next(found for found in tried if len(found) <= most), dtype=np.int64)


def _jumps(levels: list[float], size: float) -> list[int]:
    """Steps after which a level is this far from that after the last of them, or from the first."""
    found, level = [], levels[0]
    for k, now in enumerate(levels):
        if abs(now - level) >= size:
            found.append(k - 1)
            level = now
    return found


class _Sender:
    """Listener that sends every iterate, those of some seconds together, since small meshes send fast."""

    def __init__(
        self, messages: queue.Queue[Message | None], stopped: Connection, gather: float = 0.01
    ) -> None:
        self._messages, self._stopped, self._gather = messages, stopped, gather
        self._unsent: list[Iterate] = []
        self._began = self._sent = time.monotonic()

    def __call__(self, iterate: Iterate) -> None:
        self._unsent.append(replace(iterate, details=None))
        if time.monotonic() > self._sent + self._gather:
            self.flush()
        if self._stopped.poll():
            raise StopIteration

    def flush(self) -> None:
        """Send the iterates that are held back."""
        self._sent = time.monotonic()
        if self._unsent:
            self._messages.put(("iterates", (self._sent - self._began, self._unsent)))
        self._unsent = []


def _end_with_window() -> None:
    """If the other process was killed, end this one: it would wait for ever for its messages to be taken."""
    window = multiprocessing.parent_process()
    if window is not None:
        window.join()
        os._exit(1)


def _send_all(messages: queue.Queue[Message | None], pipe: Connection) -> None:
    """Send messages up to None; if that fails, this process ends, which the window says."""
    try:
        for message in iter(messages.get, None):
            pipe.send(message)
    except Exception:
        os._exit(1)


def _work(
    load: Callable[[], Source],
    repair: Mapping[str, Any] | None,
    solve: Solve,
    pipe: Connection,
    stopped: Connection,
    in_transit: int = 64,
) -> None:
    """The process: whatever happens, its last message is the result or the error.

    If too many messages are held, more than a run sends while a window draws a picture, it waits.
    """
    threading.Thread(target=_end_with_window, daemon=True).start()
    messages: queue.Queue[Message | None] = queue.Queue(in_transit)
    sending = threading.Thread(target=_send_all, args=(messages, pipe))
    sending.start()
    try:
        v, f = load()
        if repair is not None:
            repaired = repair_mesh(v, f, **repair)
            v, f = repaired.v, repaired.f
        check_mesh(v, f)
        messages.put(("mesh", (v, f)))
        sender = _Sender(messages, stopped)
        try:
            result = solve(v, f, listener=sender)
        finally:
            sender.flush()
        messages.put(("result", result))
    except Exception as error:  # shown in the window
        messages.put(("error", error))
    messages.put(None)
    sending.join()
