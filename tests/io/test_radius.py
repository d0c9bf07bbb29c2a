"""Spheres of any radius are certified on their own scale."""

import numpy as np
import pytest
from triangulations import icosphere

from igl_spheremap.io.written_map import certify_radius

X, F = icosphere(2)


@pytest.mark.parametrize("radius", [1e-300, 1e-170, 1e-110, 1e-3, 100.0, 1e105, 1e155, 1e300])
def test_a_sphere_of_any_radius_is_certified(radius):
    check = certify_radius(radius * X, F)
    assert check.certificate.folding_free
    assert check.radius == pytest.approx(radius, rel=1e-12)


@pytest.mark.parametrize("radius", [1.1e-103, 1e-170, 1e155])
def test_a_flipped_face_is_found_at_any_radius(radius):
    x = radius * X
    x[[3, 50]] = x[[50, 3]]
    certificate = certify_radius(x, F).certificate
    assert not certificate.folding_free
    assert len(certificate.flipped) >= 4
    assert len(certificate.off_sphere) == 0


def test_rows_that_are_not_finite_change_no_radius():
    check = certify_radius(100 * np.where(np.arange(len(X))[:, None] == 7, np.nan, X), F)
    assert check.radius == pytest.approx(100)
    assert check.certificate.not_finite.tolist() == [7]
    assert len(check.certificate.off_sphere) == 0


def test_rows_off_the_sphere_are_off_relative_to_the_radius():
    x = 1e-200 * X * np.where(np.arange(len(X)) == 7, 1.001, 1.0)[:, None]
    assert certify_radius(x, F).certificate.off_sphere.tolist() == [7]
