"""The corpus of meshes, where there is one, and Ctrl-C as on a terminal."""

import signal

import pytest
from corpus import CORPUS


def pytest_configure():
    """Take Ctrl-C as on a terminal: a run in the background ignores it, and so would the programs that tests start."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items):
    """Skip what needs the corpus where there is none."""
    if not CORPUS.is_dir():
        for item in items:
            if "corpus" in item.keywords:
                item.add_marker(pytest.mark.skip(reason="no corpus of meshes here"))


@pytest.fixture(scope="session")
def corpus():
    """Folder of the corpus."""
    return CORPUS
