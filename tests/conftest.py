"""The corpus of meshes, if any, features of POSIX systems, and Ctrl-C as on a terminal."""

import gc
import os
import signal

import pytest
from corpus import CORPUS

# BLAS threads fight the tests' own processes for the cores; NumPy reads this when a test file first imports it.
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# Tests start some 150 processes; without stored bytecode each of them would compile the package again.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


def pytest_configure():
    """Take Ctrl-C as on a terminal: a run in the background ignores it, and so would the programs that tests start."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items):
    """Without the corpus, or a POSIX system, skip the tests that need it."""
    here = {"corpus": CORPUS.is_dir(), "posix": os.name == "posix"}
    for item in items:
        for name, found in here.items():
            if name in item.keywords and not found:
                item.add_marker(pytest.mark.skip(reason=f"no {name} here"))


def pytest_collection_finish():
    """Keep what was collected, which lives to the end, out of the garbage collector's rounds: a tenth of the time."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True)
def nothing_is_left_out(monkeypatch):
    """Raise errors that a repair would only note: a step that fails costs no user the map, but is a defect."""

    def fail(name, error):
        raise AssertionError(f"the step {name} failed") from error

    monkeypatch.setattr("igl_spheremap.angles.repair.left_out", fail)


@pytest.fixture(scope="session")
def corpus():
    """Folder of the corpus."""
    return CORPUS
