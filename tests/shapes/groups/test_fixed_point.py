"""The mean of a group as mathematics: rounds over arrays, without files."""

import numpy as np
import pytest
from family import body

from igl_spheremap.resampling.transfer import sphere_mesh
from igl_spheremap.shapes.groups.fixed_point import Registered, fixed_point
from igl_spheremap.shapes.groups.procrustes import generalised_procrustes

X, F = sphere_mesh("ico:1")
SHAPES = np.stack([body(X, bend, bulge) for bend, bulge in ((-1, 0), (0, 0.5), (1, 0), (0.5, 1), (0, -1))])


class Constant:
    """Members whose points do not depend on the template; in some searches somebody turns."""

    def __init__(self, shapes, turned=()):
        self.shapes, self.turned, self.searches = shapes, list(turned), []

    def __call__(self, members, target, search):
        self.searches.append(search)
        turned = self.turned.pop(0) if search and self.turned else 0
        return Registered(list(members), self.shapes[members], np.ones(len(X)), turned)


def found(register):
    return fixed_point(register, range(len(SHAPES)), SHAPES[0], X, F, balance=1.0, rigid=True)


def test_the_mean_of_members_that_stay_is_that_of_procrustes():
    register = Constant(SHAPES)
    fixed = found(register)
    assert np.allclose(fixed.mean, generalised_procrustes(SHAPES, np.ones(len(X)), rigid=True).mean)
    assert fixed.changes[-1] == pytest.approx(0, abs=1e-9)
    assert fixed.members == [0, 1, 2, 3, 4]
    assert register.searches == [False, False, True]


def test_other_rotations_are_tried_until_nobody_turns():
    register = Constant(SHAPES, turned=[2, 1])
    found(register)
    assert register.searches.count(True) == 3
    register = Constant(SHAPES, turned=[1] * 9)
    found(register)
    assert register.searches.count(True) == 3


def test_a_mean_that_does_not_settle_ends_after_some_rounds():
    rng = np.random.default_rng(0)

    def restless(members, target, search):
        return Registered(list(members), SHAPES + 0.1 * rng.normal(size=SHAPES.shape), np.ones(len(X)), 0)

    fixed = found(restless)
    assert len(fixed.changes) == 10
    assert not fixed.settled


def test_a_contraction_leads_to_its_fixed_point():
    def towards(members, target, search):
        return Registered(list(members), SHAPES + 0.25 * (target.vertices - SHAPES[0]), np.ones(len(X)), 0)

    fixed = found(towards)
    steps = np.array(fixed.changes[1:4])
    assert (steps[1:] < 0.6 * steps[:-1]).all()
    assert fixed.settled
