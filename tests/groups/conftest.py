import pytest
from family import AMOUNTS, family

import igl_spheremap as ism


@pytest.fixture(scope="session")
def maps():
    """Six bodies of a family, each meshed, turned and moved anew, and mapped."""
    return [ism.balanced_spherical_map(*each, balance=1) for each in family(AMOUNTS)]


@pytest.fixture(scope="session")
def three(maps):
    """The group of three of them."""
    return ism.template(maps[:3], target="ico:2")


@pytest.fixture(scope="session")
def group(maps):
    """The group of all."""
    return ism.template(maps, target="ico:2", features=[each.vertices for each in maps])
