"""The gauge: a rotation that is recovered and never mirrors, and a sphere that does not see the surface's motion."""

import numpy as np
from triangulations import icosphere, random_points, random_rotation

from igl_spheremap import check_mesh
from igl_spheremap.sphere.gauge import best_rotation, fix_gauge
from igl_spheremap.sphere.moebius import moebius


def test_best_rotation_recovers_a_rotation_and_never_mirrors():
    x = random_points()
    turn = random_rotation(4)
    assert np.allclose(best_rotation(x, x @ turn, np.ones(200)), turn)
    assert np.isclose(np.linalg.det(best_rotation(x, x * [1, 1, -1], np.ones(200))), 1)
    assert np.isclose(np.linalg.det(best_rotation(x, np.zeros_like(x), np.ones(200))), 1)


def test_the_gauge_does_not_see_moebius_maps_and_turns_with_the_surface():
    x, f = icosphere(3)
    v = x * [1, 1.3, 2]
    mesh = check_mesh(v, f)
    turn = random_rotation(4)
    expected = fix_gauge(mesh, x)
    assert np.abs(mesh.A @ expected).max() < 1e-9
    assert np.allclose(fix_gauge(mesh, moebius(x, [0.3, -0.5, 0.6]) @ turn), expected, atol=1e-9)
    turned = check_mesh(v @ turn, f)
    assert np.allclose(fix_gauge(turned, x), expected @ turn, atol=1e-9)
