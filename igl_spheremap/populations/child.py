"""A process that runs one call at a time for a thread, and can be ended when a call passes a limit.

multiprocessing and pebble, which rests on it, are not used. Their processes import the starting script, which would
have to guard itself; a scheduler's SIGTERM ends their jobs. Two processes of pebble, which read from one pipe under a
lock, took 1.6 times as long (100 meshes of 800 vertices, medians of 12 rounds in turn).
"""

from __future__ import annotations

import contextlib
import gc
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

T = TypeVar("T")
_SERVE = "import sys; sys.path[:] = sys.argv[1:]; from igl_spheremap.populations.child import serve; serve()"
#: One thread each, since the processes share the processors. And glibc is to keep the memory that a map frees for the
#: next one: the system clears each page that it gives, which takes a tenth to a fifth of a map of 50,000 vertices.
_ENVIRONMENT = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "IGL_NUM_THREADS"), "1"
) | dict.fromkeys(("MALLOC_TRIM_THRESHOLD_", "MALLOC_MMAP_THRESHOLD_"), str(1 << 40))

_OF_THREAD = threading.local()


class WorkerDied(RuntimeError):
    """The process of a call ended before the call did; `pid` was its number; if we ended it, `reason` is set."""

    def __init__(self, pid: int, status: int, reason: str = "") -> None:
        super().__init__(pid, status, reason)  # by which it is pickled: Dask sends it to the client
        self.pid, self.status, self.reason = pid, status, reason

    def __str__(self) -> str:
        if self.reason:
            return self.reason
        if self.status < 0:
            return f"its process ended by signal {-self.status}, perhaps for lack of memory"
        return f"its process ended with status {self.status}"


class Child:
    """A Python process that is started at the first call, and anew after it was ended.

    It inherits neither Ctrl-C, since it has a session of its own, nor the caller's `__main__`.
    """

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None

    def call(self, function: Callable[..., T], *args: Any, timeout: float | None = None) -> T:
        """The function's result; if its process ends, or passes some seconds, raise WorkerDied."""
        process = self._running(function, *args)
        limit, reason = threading.Timer(threading.TIMEOUT_MAX, process.kill), ""
        began = time.monotonic()
        try:
            if timeout is not None:
                limit.interval = min(timeout, threading.TIMEOUT_MAX)
                limit.start()
            failed, value = _ask(process, function, *args)
        except (EOFError, OSError, pickle.UnpicklingError):
            self.end()
            if timeout is not None and time.monotonic() - began >= timeout:
                reason = f"it took more than {timeout:g} s, the limit"
            raise WorkerDied(process.pid, process.returncode, reason) from None
        finally:
            limit.cancel()
        if failed:
            raise value
        return value

    def _running(self, *call: Any) -> subprocess.Popen[bytes]:
        """The process, with a call's modules loaded, so that its time and memory do not include that."""
        if self._process is None or self._process.poll() is not None:
            self.end()
            self._process = subprocess.Popen(
                [sys.executable, "-c", _SERVE, *sys.path],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                env=_ENVIRONMENT | os.environ,
                **_apart(),
            )
            with contextlib.suppress(EOFError, OSError):  # a fault here will show in the call
                _ask(self._process, _load, *call)
        return self._process

    def end(self) -> None:
        """End the process in any state."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            for pipe in (self._process.stdin, self._process.stdout):
                assert pipe is not None
                with contextlib.suppress(OSError):  # the unsent rest of a call
                    pipe.close()


def _apart() -> dict[str, Any]:
    """Arguments of Popen by which neither Ctrl-C nor, on Windows, Ctrl-Break of our terminal reaches a process."""
    if sys.platform == "win32":
        return {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    return {"start_new_session": True}


def _ask(
    process: subprocess.Popen[bytes], function: Callable[..., Any], *args: Any
) -> tuple[bool, Any]:
    """Send a call, and wait for its success or failure, and its result or error."""
    assert process.stdin is not None
    assert process.stdout is not None
    pickle.dump((function, args), process.stdin)
    process.stdin.flush()
    answer: tuple[bool, Any] = pickle.load(process.stdout)
    return answer


def _load(*call: object) -> None:
    """Exempt the modules that came with a call from garbage collection: calls take 7 percent less time."""
    gc.freeze()


def serve() -> None:
    """Run the calls that come by stdin, and send their results to stdout, until stdin is closed."""
    # a scheduler may send them to every process of a job
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    calls, results = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # prints of libraries do not get among the results
    while True:
        try:
            function, args = pickle.load(calls)
        except EOFError:
            return
        with contextlib.suppress(OSError), open("/proc/self/clear_refs", "w") as file:
            file.write("5")  # from here on the peak of memory is that of the call
        try:
            answer = (False, function(*args))
        except Exception as error:
            answer = (True, error)
        try:
            pickle.dump(answer, results)
            results.flush()
        except BrokenPipeError:  # the parent was killed
            os._exit(1)


def own_child() -> Child:
    """The process that belongs to this thread."""
    if not hasattr(_OF_THREAD, "child"):
        _OF_THREAD.child = Child()
    child: Child = _OF_THREAD.child
    return child


class ProcessPool(ThreadPoolExecutor):
    """An executor whose threads each own a process, which can be ended without the others."""

    def __init__(self, workers: int | None) -> None:
        self._children: list[Child] = []
        if workers is None:
            workers = processors()
        super().__init__(workers, initializer=lambda: self._children.append(own_child()))

    def end(self) -> None:
        """End all processes at once, in any state, and take no more calls."""
        self.shutdown(wait=False, cancel_futures=True)
        for child in self._children:
            child.end()


def processors() -> int:
    """Their number; 1 if the system does not say."""
    known = os.cpu_count()
    if known is None:
        return 1
    return known


def peak_memory() -> float:
    """Most memory that this process held in its call so far, in MB; NaN if the system does not report it."""
    try:
        with open("/proc/self/status") as file:
            return next(int(line.split()[1]) / 1024 for line in file if line.startswith("VmHWM"))
    except (OSError, StopIteration):
        return float("nan")
