"""Rotations of coefficients are rotations of functions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from igl_spheremap.shapes.harmonics.basis import power, rows_of, synthesis
from igl_spheremap.shapes.harmonics.rotation import (
    best_rotations,
    euler_angles,
    from_complex,
    rotate,
    rotation_angle,
    to_complex,
)
from igl_spheremap.sphere.rows import unit_rows

RNG = np.random.default_rng(0)
X = unit_rows(RNG.normal(size=(60, 3)))
C = RNG.normal(size=(21**2, 2))
ANGLES = [
    (0.3, 1.2, -2.0),
    (0, 0, 0),
    (0.3, 0, 0),
    (0, 0, 0.3),
    (0.7, np.pi, 0),
    (1, 1e-13, 2),
    (1, np.pi - 1e-13, 2),
]


@pytest.mark.parametrize("angles", ANGLES)
def test_rotated_coefficients_are_those_of_the_rotated_function(angles):
    R = Rotation.from_euler("ZYZ", angles).as_matrix()
    assert np.abs(synthesis(rotate(C, R), X) - synthesis(C, X @ R)).max() < 1e-12  # f(R^-1 x), rows
    assert np.abs(Rotation.from_euler("ZYZ", euler_angles(R)).as_matrix() - R).max() < 1e-15


def test_rotations_compose_and_keep_power():
    Q, R = Rotation.from_euler("ZYZ", [[0.3, 1.2, -2], [-1, 2.9, 0.4]]).as_matrix()
    assert np.abs(rotate(rotate(C, R), Q) - rotate(C, Q @ R)).max() < 1e-12
    assert np.allclose(power(rotate(C, R)), power(C), rtol=1e-13)


def test_the_complex_basis_and_back():
    for ell in (0, 1, 5):
        rows = C[ell * ell : (ell + 1) ** 2]
        assert np.allclose(from_complex(to_complex(rows)), rows, atol=1e-15)
        assert np.isclose(np.linalg.norm(to_complex(rows)), np.linalg.norm(rows))


def random_rotation(rng):
    return Rotation.from_euler(
        "ZYZ", [rng.uniform(0, 7), np.arccos(rng.uniform(-1, 1)), rng.uniform(0, 7)]
    ).as_matrix()


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
        known = (
            (fixed[1:] * turned[1:]).sum() / np.linalg.norm(fixed[1:]) / np.linalg.norm(moving[1:])
        )
        assert np.isclose(value, known)
        for axis in np.eye(3):  # a maximum: no small rotation is better
            for angle in (1e-3, -1e-3):
                beside = rotate(turned, Rotation.from_rotvec(angle * axis).as_matrix())
                assert (fixed[1:] * beside[1:]).sum() < (fixed * turned)[1:].sum()


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
    assert np.array_equal(
        best_rotations(c, c, 6)[0].rotation, best_rotations(changed, c, 6)[0].rotation
    )


def test_angles_of_rotations():
    for w in (np.zeros(3), np.array([1e-9, 0, 0]), np.array([0.3, -1.0, 2.0])):
        R = Rotation.from_rotvec(w).as_matrix()
        assert np.isclose(np.radians(rotation_angle(R)), np.linalg.norm(w), rtol=1e-9, atol=1e-16)
