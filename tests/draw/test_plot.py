"""Pictures by numpy show the front, at its place, at any resolution."""

import tracemalloc

import numpy as np
import pytest

from igl_spheremap import samples
from igl_spheremap.draw.palette import FOLDED
from igl_spheremap.draw.plot import extremes, raster

RED, BLUE = [1.0, 0, 0], [0, 0, 1.0]


@pytest.mark.parametrize("vertices", [42, 642, 40962])
def test_a_ball_is_a_disc_without_holes(vertices):
    v, f = samples.sphere(vertices)
    image = raster(v, f, np.zeros((len(f), 3)), 101)
    row, column = np.indices((101, 101)) - 50
    distance = np.hypot(row, column) / 50.5 * 1.06
    flat = np.sqrt(1 - 8 / vertices)  # of a coarse ball the outline is a polygon
    assert (image[distance < 0.98 * flat - 0.02] == 0).all()
    assert (image[distance > 1.03] == 255).all()


def test_what_is_in_front_hides_what_is_behind():
    square = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    small = 0.5 * square + [0, 0, 1]
    for first, second in ((0, 4), (4, 0)):
        v = np.concatenate((square, small)) if first == 0 else np.concatenate((small, square))
        f = np.concatenate((faces + first, faces + second))
        image = raster(v, f, np.repeat([BLUE, RED], 2, axis=0), 61)
        assert (image[20:40, 20:40] == [255, 0, 0]).all()
        assert (image[30, [4, -5]] == [0, 0, 255]).all()


def test_up_is_up_and_right_is_right():
    v = np.array([[-1.0, -1, 0], [1, -1, 0], [-1, 1, 0]])
    image = raster(v, np.array([[0, 1, 2]]), np.array([RED]), 50)
    assert (image[8, 8] == [255, 0, 0]).all()
    assert (image[-8, -10] == [255, 0, 0]).all()
    assert (image[8, -8] == 255).all()


def test_no_folded_face_is_hidden_or_smaller_than_three_pixels():
    """A needle behind a square is drawn before it, a vermilion block; one in the farther half is not."""
    square = np.array([[-1.0, -1, 0.5], [1, -1, 0.5], [1, 1, 0.5], [-1, 1, 0.5]])
    for depth, seen in ((0.4, True), (-0.5, False)):
        needle = 1e-4 * np.array([[-1.0, 0, 0], [1, 0, 0], [0, 1, 0]]) + [0, 0, depth]
        v = np.concatenate((square, needle, [[0, 0, -0.5]]))
        f = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6]])
        image = raster(v, f, np.repeat([BLUE], 3, axis=0), 61, np.array([2]))
        vermilion = (image == np.rint(255 * np.array(FOLDED))).all(axis=2)
        assert vermilion.sum() == (9 if seen else 0)
        assert vermilion[29:32, 29:32].all() == seen


def test_large_faces_are_drawn_in_parts():
    """A hundred faces as large as the picture: their points take 500 MB if they are all made at once."""
    corners = np.random.default_rng(0).uniform(-1, 1, (300, 3))
    tracemalloc.start()
    raster(corners, np.arange(300).reshape(-1, 3), np.zeros((100, 3)), 512)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 100e6


@pytest.mark.parametrize(("count", "bins"), [(0, 5), (1, 5), (5, 5), (17, 5), (1000, 7)])
def test_a_curve_keeps_the_least_and_the_largest_value_of_each_bin(count, bins):
    values = np.random.default_rng(count).normal(size=count)
    drawn = extremes(values, bins)
    part = np.arange(count) * bins // max(count, 1)
    least_and_largest = {
        f(np.flatnonzero(part == k), key=values.__getitem__) for k in set(part) for f in (min, max)
    }
    assert drawn.tolist() == sorted(least_and_largest)
