"""Colours of numbers."""

from __future__ import annotations

import numpy as np
import pytest

from igl_spheremap.draw.palette import area_ramp, colours


def test_colours_of_anything():
    for values in (np.zeros(5), np.array([np.nan, np.inf, -np.inf, 0, 1]), np.full(3, np.nan)):
        assert all(channel.dtype == np.uint8 for channel in colours(values).values())


def test_colours_of_areas_fit_the_data():
    """Whatever the size of the differences, most are coloured, and few reach the ends; their factors are named."""
    normal = np.random.default_rng(0).normal(size=999)
    for size in (0.02, 0.3, 4.0, 300.0):
        ramp = area_ramp(np.append(size * normal, [50 * size, -np.inf]))
        assert 0.55 < (np.abs(size * normal) < ramp.high).mean() < 0.99
        assert ramp.low == -ramp.high
        if size < 300:
            assert np.log(float(ramp.ends[1])) == pytest.approx(ramp.high)
