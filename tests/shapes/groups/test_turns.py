"""Turns and mirror images that bring a shape nearer to another one are found where they are planted."""

import numpy as np
import pytest
from family import body
from scipy.spatial.transform import Rotation

import igl_spheremap as ism
from igl_spheremap.resampling.transfer import sphere_mesh
from igl_spheremap.shapes.groups.procrustes import fitted
from igl_spheremap.shapes.groups.turns import NO_RESTARTS, Turns
from igl_spheremap.shapes.harmonics.rotation import rotation_angle

X, F = sphere_mesh("ico:3")
TURNS = Turns(X)
ANY = Rotation.from_rotvec([0.4, 1.0, 0.3]).as_matrix()


def tried(mean, shape):
    axis, (restarts,) = TURNS.restarts(mean, [shape])
    return axis, restarts


@pytest.mark.parametrize("space", [np.eye(3), 3 * ANY])
def test_the_turn_that_brings_a_shape_back_is_tried_first(space):
    half = np.diag([1.0, -1, -1])  # the body is long: after half a turn it lies nearly as near
    _, restarts = tried(body(X, bulge=1), body(X @ half, bulge=1.1) @ space + 5)
    assert rotation_angle(np.array(restarts.turns[0]) @ half) < 5


def test_what_lies_right_tries_nothing():
    assert tried(body(X), body(X, bend=0.2)) == (None, NO_RESTARTS)


def test_a_mirror_image_is_tried():
    mirrored = ism.resample(
        ism.sphere_map(body(X) * [-1, 1, 1], F[:, ::-1], X * [-1, 1, 1]), (X, F)
    ).v
    assert tried(body(X), mirrored)[1].mirror


def round_body(x, bump=0.0):
    """A pear about the axis (0, .6, .8), perhaps with a bump beside it."""
    along = x @ [0, 0.6, 0.8]
    beside = np.exp(-4 * ((x - [1, 0, 0]) ** 2).sum(axis=1))
    return x * (1 + 0.3 * along + 0.4 * along**2 + bump * beside)[:, None]


def test_a_round_body_has_its_axis_and_is_turned_to_the_least_distance():
    turn = Rotation.from_rotvec(np.radians(70) * np.array([0, 0.6, 0.8])).as_matrix()
    mean, shape = round_body(X, bump=0.05), round_body(X @ turn.T, bump=0.1)
    axis, _ = TURNS.restarts(mean, [shape])
    assert abs(axis @ [0, 0.6, 0.8]) > 0.99
    (found,) = TURNS.about(axis, mean, [shape])
    assert rotation_angle(found @ turn.T) < 5
    before, after = (
        np.linalg.norm(fitted(each, mean, np.ones(len(X)))[0] - mean)
        for each in (shape, round_body(X @ found @ turn.T, bump=0.1))
    )
    assert after < 0.8 * before
