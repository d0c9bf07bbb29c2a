"""Scalar maps over the vertices."""

from __future__ import annotations

import numpy as np
import pytest

from igl_spheremap import angle_differences, conformal_factor, samples, spherical_conformal_map
from igl_spheremap.verify.vertex_maps import vertex_maps


def test_the_maps_are_what_they_say():
    result = spherical_conformal_map(*samples.make("spheroid", n_vertices=600))
    maps = vertex_maps(result.vertices * 7, result.faces, result.sphere)
    factor = conformal_factor(result.vertices, result.faces, result.sphere)
    assert np.allclose(np.exp(2 * maps["factor"]) * 4 * np.pi, factor)
    size = np.abs(angle_differences(result.vertices, result.faces, result.sphere))
    for i in (0, 100, 500):
        assert maps["angles"][i] == pytest.approx(size[result.faces == i].mean())
