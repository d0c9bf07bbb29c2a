"""Rotations found by correlation: planted ones, all maxima, derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from igl_spheremap.shapes.harmonics.basis import rows_of, synthesis
from igl_spheremap.shapes.harmonics.rotation import euler_rotation, rotate, turning
from igl_spheremap.shapes.registration.correlation import best_rotations, rotation_about, rotation_angle
from igl_spheremap.sphere.rows import unit_rows


def random_rotation(rng):
    return euler_rotation(rng.uniform(0, 7), np.arccos(rng.uniform(-1, 1)), rng.uniform(0, 7))


@pytest.mark.parametrize("band", [4, 16, 32])
@pytest.mark.parametrize("seed", range(3))
def test_planted_rotations_of_band_limited_data_come_back(band, seed):
    rng = np.random.default_rng(seed)
    moving = rng.normal(size=(band**2, 2))
    R = random_rotation(rng)
    best = best_rotations(rotate(moving, R), moving, band)[0]
    assert np.radians(rotation_angle(best.rotation @ R.T)) < 1e-10
    assert np.isclose(best.correlation, 1)


def test_the_correlation_is_the_integral_over_the_sphere():
    rng = np.random.default_rng(0)
    fixed, moving = rng.normal(size=(2, 64, 1))
    for R, value in best_rotations(fixed, moving, 8):
        turned = rotate(moving, R)
        known = (fixed[1:] * turned[1:]).sum() / np.linalg.norm(fixed[1:]) / np.linalg.norm(moving[1:])
        assert np.isclose(value, known)
        for axis in np.eye(3):  # a maximum: no small rotation is better
            for angle in (1e-3, -1e-3):
                assert (fixed[1:] * rotate(turned, rotation_about(angle * axis))[1:]).sum() < (fixed * turned)[1:].sum()


def test_symmetric_functions_have_as_many_best_rotations():
    """x^2 - y^2 comes back by half turns about the three axes."""
    c = np.zeros((9, 1))
    c[8] = 1
    found = best_rotations(c, c, 3)
    assert len(found) == 4
    assert np.allclose([each.correlation for each in found], 1)
    assert np.allclose([np.abs(each.rotation) for each in found], np.eye(3), atol=1e-7)


def test_constants_and_higher_degrees_do_not_count():
    rng = np.random.default_rng(1)
    c = rng.normal(size=(49, 1))
    changed = c.copy()
    changed[0] += 100
    changed[rows_of(6)] = rng.normal(size=(13, 1))
    assert np.array_equal(best_rotations(c, c, 6)[0].rotation, best_rotations(changed, c, 6)[0].rotation)


def test_turning_is_the_derivative_by_rotations():
    rng = np.random.default_rng(2)
    c, x, h = rng.normal(size=(36, 2)), unit_rows(rng.normal(size=(9, 3))), 1e-6
    for axis, rate in zip(np.eye(3), turning(c), strict=True):
        R = rotation_about(h * axis)
        change = (synthesis(c, x @ R.T) - synthesis(c, x @ R)) / (2 * h)
        assert np.abs(change - synthesis(rate, x)).max() < 1e-8


def test_rotation_vectors():
    for w in (np.zeros(3), np.array([1e-9, 0, 0]), np.array([0.3, -1.0, 2.0])):
        R = rotation_about(w)
        assert np.allclose(R @ R.T, np.eye(3), atol=1e-15)
        assert np.allclose(R @ w, w)
        assert np.isclose(np.radians(rotation_angle(R)), np.linalg.norm(w), rtol=1e-9, atol=1e-16)
