"""The mean of a group as mathematics: rounds over arrays, without files."""

import numpy as np
import pytest
from family import body

from igl_spheremap.resampling.transfer import sphere_mesh
from igl_spheremap.shapes.groups.fixed_point import Registered, fixed_point
from igl_spheremap.shapes.groups.procrustes import generalised_procrustes

X, F = sphere_mesh("ico:1")
SHAPES = np.stack(
    [body(X, *amounts) for amounts in ((-0.1, 0), (0, 0.05), (0.1, 0), (0.05, 0.1), (0, -0.1))]
)


class Constant:
    """Members whose points do not depend on the template; one that lies wrong turns when its restarts say how."""

    def __init__(self, shapes, stubborn=False):
        self.shapes, self.stubborn, self.searches = shapes.copy(), stubborn, []

    def __call__(self, members, target, restarts):
        searched = [k for k, each in enumerate(restarts) if each.turns]
        self.searches.append(searched)
        if not self.stubborn:
            self.shapes[searched] = SHAPES[searched]
        return Registered(list(members), self.shapes[members], np.ones(len(X)), len(searched))


def found(register):
    return fixed_point(register, range(len(SHAPES)), SHAPES[0], X, F, balance=1.0, rigid=True)


def test_the_mean_of_members_that_stay_is_that_of_procrustes():
    register = Constant(SHAPES)
    fixed = found(register)
    assert np.allclose(fixed.mean, generalised_procrustes(SHAPES, np.ones(len(X)), rigid=True).mean)
    assert fixed.settled
    assert fixed.members == [0, 1, 2, 3, 4]
    assert not any(register.searches)


@pytest.fixture
def wrong():
    """The shapes, the last one turned by half about its longest axis."""
    shapes = SHAPES.copy()
    shapes[4] = body(X * [1, -1, -1], 0, -0.1)
    return shapes


def test_a_member_that_lies_wrong_is_tried_and_no_other(wrong):
    register = Constant(wrong)
    fixed = found(register)
    assert [searched for searched in register.searches if searched] == [[4]]
    assert np.allclose(fixed.mean, generalised_procrustes(SHAPES, np.ones(len(X)), rigid=True).mean)


def test_a_member_that_never_lies_right_is_tried_three_times(wrong):
    register = Constant(wrong, stubborn=True)
    found(register)
    assert [searched for searched in register.searches if searched] == [[4]] * 3


def test_a_mean_that_does_not_settle_ends_after_some_rounds():
    rng = np.random.default_rng(0)

    def restless(members, target, restarts):
        return Registered(
            list(members), SHAPES + 0.1 * rng.normal(size=SHAPES.shape), np.ones(len(X)), 0
        )

    fixed = found(restless)
    assert len(fixed.changes) == 10
    assert not fixed.settled


def test_a_contraction_leads_to_its_fixed_point():
    def towards(members, target, restarts):
        return Registered(
            list(members), SHAPES + 0.25 * (target.vertices - SHAPES[0]), np.ones(len(X)), 0
        )

    fixed = found(towards)
    steps = np.array(fixed.changes[1:4])
    assert (steps[1:] < 0.6 * steps[:-1]).all()
    assert fixed.settled
