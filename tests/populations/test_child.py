"""Processes that run one call at a time: their death and their limits cost the call only."""

import gc
import os
import platform
import signal
import threading
from concurrent.futures import CancelledError

import errands
import pytest

from igl_spheremap.populations.child import Child, ProcessPool, WorkerDied, own_child


@pytest.fixture(scope="module")
def child():
    child = Child()
    yield child
    child.end()


def test_calls_run_in_one_other_process_whatever_it_prints(child):
    first = child.call(errands.process)
    assert first != os.getpid()
    assert child.call(errands.process) == first


def test_errors_come_back_and_leave_the_process_alive(child):
    before = child.call(errands.process)
    with pytest.raises(ValueError, match="no"):
        child.call(errands.refuse)
    assert child.call(errands.process) == before


def test_a_process_that_dies_is_replaced(child):
    before = child.call(errands.process)
    with pytest.raises(WorkerDied, match=r"(signal|status) 9") as raised:
        child.call(errands.die)
    assert (raised.value.pid, raised.value.reason) == (before, "")
    assert child.call(errands.process) != before
    os.kill(child.call(errands.process), errands.KILL)  # between two calls
    child.end()
    assert child.call(errands.process)


def test_lack_of_memory_is_supposed_only_of_a_process_that_was_ended_from_outside(child):
    with pytest.raises(WorkerDied, match=r"its process ended with status 3$"):
        child.call(errands.leave)


def test_a_call_that_takes_too_long_is_ended(child):
    with pytest.raises(WorkerDied, match=r"more than 0\.2 s"):
        child.call(errands.wait, timeout=0.2)
    assert child.call(errands.process, timeout=60)


@pytest.mark.posix
def test_signals_of_a_terminal_do_not_end_a_call(child):
    pid = child.call(errands.process)
    for number in (signal.SIGINT, signal.SIGTERM):
        os.kill(pid, number)
    assert child.call(errands.process) == pid
    assert os.getpgid(pid) != os.getpgid(0)


def test_each_thread_has_its_own_process():
    children = [own_child()]
    thread = threading.Thread(target=lambda: children.append(own_child()))
    thread.start()
    thread.join()
    assert children[0] is own_child()
    assert children[0] is not children[1]


@pytest.mark.posix
def test_a_pool_that_is_ended_leaves_no_process():
    pool = ProcessPool(1)
    pid = pool.submit(lambda: own_child().call(errands.process)).result()
    waiting = pool.submit(lambda: own_child().call(errands.wait))
    pool.end()
    with pytest.raises((WorkerDied, CancelledError)):
        waiting.result(10)
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="other systems have other ways")
def test_freed_memory_is_kept_for_the_next_call(child):
    first, second = (child.call(errands.pages_taken) for _ in range(2))
    assert second < first / 10


@pytest.mark.filterwarnings("error::ResourceWarning")
@pytest.mark.filterwarnings("error::pytest.PytestUnraisableExceptionWarning")
def test_the_pipes_of_a_process_are_closed_when_it_ends():
    pool = ProcessPool(1)
    assert pool.submit(lambda: own_child().call(os.getpid)).result() != os.getpid()
    pool.end()
    child = Child()
    with pytest.raises(WorkerDied):
        child.call(os._exit, 3)
    child.call(os.getpid)
    child.end()
    del pool, child
    gc.collect()
