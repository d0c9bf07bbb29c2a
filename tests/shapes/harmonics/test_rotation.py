"""Rotations of coefficients are rotations of functions."""

from __future__ import annotations

import numpy as np
import pytest

from igl_spheremap.shapes.harmonics.basis import power, synthesis
from igl_spheremap.shapes.harmonics.rotation import euler_angles, euler_rotation, from_complex, rotate, to_complex
from igl_spheremap.sphere.rows import unit_rows

RNG = np.random.default_rng(0)
X = unit_rows(RNG.normal(size=(60, 3)))
C = RNG.normal(size=(21**2, 2))
ANGLES = [(0.3, 1.2, -2.0), (0, 0, 0), (0.3, 0, 0), (0, 0, 0.3), (0.7, np.pi, 0), (1, 1e-13, 2), (1, np.pi - 1e-13, 2)]


@pytest.mark.parametrize("angles", ANGLES)
def test_rotated_coefficients_are_those_of_the_rotated_function(angles):
    R = euler_rotation(*angles)
    assert np.abs(synthesis(rotate(C, R), X) - synthesis(C, X @ R)).max() < 1e-12  # f(R^-1 x), rows
    assert np.abs(euler_rotation(*euler_angles(R)) - R).max() < 1e-15


def test_rotations_compose_and_keep_power():
    Q, R = euler_rotation(0.3, 1.2, -2), euler_rotation(-1, 2.9, 0.4)
    assert np.abs(rotate(rotate(C, R), Q) - rotate(C, Q @ R)).max() < 1e-12
    assert np.allclose(power(rotate(C, R)), power(C), rtol=1e-13)


def test_euler_rotations_are_rotations():
    R = euler_rotation(0.3, 1.2, -2)
    assert np.allclose(R @ R.T, np.eye(3), atol=1e-15)
    assert np.isclose(np.linalg.det(R), 1)


def test_the_complex_basis_and_back():
    for ell in (0, 1, 5):
        rows = C[ell * ell : (ell + 1) ** 2]
        assert np.allclose(from_complex(to_complex(rows)), rows, atol=1e-15)
        assert np.isclose(np.linalg.norm(to_complex(rows)), np.linalg.norm(rows))
