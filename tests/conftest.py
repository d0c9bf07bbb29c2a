"""The corpus of meshes, where there is one."""

import os
from pathlib import Path

import pytest

CORPUS = Path(os.environ.get("IGL_SPHEREMAP_MESHES", Path(__file__).parents[2] / "shared" / "meshes"))


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
