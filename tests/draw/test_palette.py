"""Colours of numbers."""

from __future__ import annotations

import numpy as np
import pytest

from igl_spheremap.draw.palette import ANGLES, AREAS, FACTORS, colours, fitting


def test_colours_of_anything():
    for values in (np.zeros(5), np.array([np.nan, np.inf, -np.inf, 0, 1]), np.full(3, np.nan)):
        assert all(channel.dtype == np.uint8 for channel in colours(values).values())


def test_a_scale_is_one_of_few_and_the_first_that_fits():
    """Most measures lie within, and a map that keeps areas is pale."""
    normal = np.random.default_rng(0).normal(size=999)
    for size in (0.02, 0.3, 4.0):
        ramp = fitting(AREAS, np.append(size * normal, [50 * size, -np.inf]))
        assert (np.abs(size * normal) < ramp.high).mean() > 0.55
        assert ramp.low == -ramp.high
        assert np.log(float(ramp.ends[1])) == pytest.approx(ramp.high)
    assert fitting(AREAS, 0.037 * normal).colours(0.037 * normal).min() > 0.8
    for ramps, good in ((AREAS, 0.0), (ANGLES, 0.0), (FACTORS, 0.0)):
        assert all(ramp.colours(np.array([good])).min() > 0.84 for ramp in ramps)
