"""What is measured of maps is the same at every scale of float64."""

from __future__ import annotations

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.correspondence.overlay import overlay
from igl_spheremap.correspondence.stretch import Distortion
from igl_spheremap.correspondence.surface_map import nearest


@pytest.fixture(scope="module")
def pair():
    return [ism.spherical_conformal_map(*ism.samples.make(name, n_vertices=300)) for name in ("pear", "spheroid")]


def scaled(result, unit):
    return ism.sphere_map(unit * result.vertices, result.faces, result.sphere)


@pytest.mark.parametrize("unit", [2.0**-900, 2.0**-560, 2.0**330, 2.0**530, 2.0**996])  # powers of 2 round nothing
def test_measures_do_not_depend_on_the_unit(pair, unit):
    a, b = pair
    far_a, far_b = (scaled(each, unit) for each in pair)
    weights, far = ism.transfer_weights(a, b), ism.transfer_weights(far_a, far_b)
    assert np.array_equal(weights.matrix.toarray(), far.matrix.toarray())
    harmonics, far = ism.spherical_harmonics(a, degree=3), ism.spherical_harmonics(far_a, degree=3)
    assert np.array_equal(harmonics.error(), far.error())
    assert np.allclose(harmonics.align().skew, far.align().skew, atol=1e-9)
    found, far = overlay(a, b), overlay(far_a, far_b)
    assert np.array_equal(found.faces, far.faces)
    assert np.array_equal(found.on_target, far.on_target / unit)
    measures = [Distortion.of(each.on_source, each.on_target, each.faces).figures for each in (found, far)]
    assert measures[0] == measures[1]
    points = 1.01 * a.vertices[:20]
    assert np.array_equal(nearest(a, points, "A").face, nearest(far_a, unit * points, "A").face)
