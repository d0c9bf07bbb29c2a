"""Points with anchors: the same point of the sphere from every anchor, and digits beside one that 0 does not keep."""

from __future__ import annotations

import numpy as np
import pytest

from igl_spheremap.sphere.log_plane import (
    Anchored,
    exponential,
    log_sum,
    logarithm,
    plane_angles,
    to_ball,
)
from igl_spheremap.sphere.rows import INFINITE

ENDS = np.array([0, 1, -1, 1j, -1j])


@pytest.fixture
def z():
    rng = np.random.default_rng(0)
    return np.exp(rng.normal(scale=3, size=(200, 2)) @ [1, 1j])


@pytest.mark.parametrize("anchor", ENDS)
def test_a_point_is_the_same_from_every_anchor(z, anchor):
    x = to_ball(Anchored(z))
    assert np.abs(to_ball(Anchored(z - anchor, np.full(len(z), anchor))) - x).max() < 1e-14
    assert np.abs((x * x).sum(axis=1) - 1).max() < 1e-15


@pytest.mark.parametrize("anchor", ENDS)
def test_turned_points_are_as_far_from_0_as_they_were_from_their_anchors(z, anchor):
    x, end = to_ball(Anchored(z)), to_ball(Anchored(np.array([anchor])))
    turned = Anchored(z - anchor, anchor).turned()
    assert 2 * np.arctan(np.abs(turned)) == pytest.approx(
        np.arccos(np.clip((x @ end.T)[:, 0], -1, 1)).astype(float)
    )


@pytest.mark.parametrize("anchor", ENDS)
def test_beside_an_anchor_two_coordinates_keep_their_digits(anchor):
    step = 1e-200 * np.exp(0.7j)
    x = to_ball(Anchored(np.array([step]), np.array([anchor])))[0].astype(float)
    *small, large = np.sort(np.abs(x)).tolist()
    assert large == 1
    assert np.hypot(*np.array(small) / 1e-200) == pytest.approx(
        2 / (1 + abs(anchor) ** 2), rel=1e-15
    )


def test_offsets_from_a_point_are_places_from_the_anchors_of_others(z):
    anchor = ENDS[np.arange(len(z)) % 5]
    points, rows = Anchored(z - anchor, anchor), np.array([3, 4, 10, 17])
    assert points.beside(7, z[rows] - z[7], rows) == pytest.approx(points.z[rows])


def test_logarithms_are_those_of_the_numbers(z):
    assert np.allclose(np.exp(logarithm(z)), z)
    assert np.allclose(exponential(logarithm(z)), z)
    assert logarithm(0j).real == -np.inf
    assert np.isclose(abs(exponential(np.array([1e4 + 1j]))), INFINITE)
    w = z[::-1]
    assert np.allclose(np.exp(log_sum(logarithm(z), logarithm(w))), z + w)
    far = log_sum(np.array([5000 + 1j]), np.array([4999 + 1j]))
    assert np.allclose(far, 5000 + np.log1p(np.exp(-1)) + 1j)
    assert np.isneginf(log_sum(logarithm(np.zeros(1)), logarithm(0j)).real).all()


def test_angles_of_triangles_in_the_plane_sum_to_half_a_turn_with_the_sign_of_their_area(z):
    corners = z[:198].reshape(-1, 3)
    angles = plane_angles(corners)
    a, b, c = corners.T
    area = ((b - a).conj() * (c - a)).imag
    assert np.allclose(angles.sum(axis=1), np.pi * np.sign(area))
    cosine = ((b - a).conj() * (c - a)).real / np.abs((b - a) * (c - a))
    assert np.allclose(np.cos(angles[:, 0]), cosine)
