"""The corpus of meshes, where there is one."""


import pytest
from corpus import CORPUS


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
