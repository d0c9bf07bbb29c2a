from concurrent.futures import ThreadPoolExecutor

import pytest
from family import AMOUNTS, family

import igl_spheremap as ism


@pytest.fixture(scope="session")
def maps():
    """Six bodies of a family, each meshed, turned and moved anew, and mapped."""
    return [ism.balanced_spherical_map(*each, balance=1) for each in family(AMOUNTS)]


@pytest.fixture(scope="session")
def here():
    """An engine of this process: starting others takes longer than some groups."""
    with ThreadPoolExecutor(1) as executor:
        yield ism.Engine(executor=executor)


@pytest.fixture(scope="session")
def group(maps, here):
    """Their group."""
    return ism.shapes.template(
        maps, target="ico:2", features=[each.vertices for each in maps], engine=here
    )


@pytest.fixture(scope="session")
def three(maps, here):
    """The group of the first three."""
    return ism.shapes.template(maps[:3], target="ico:2", engine=here)
