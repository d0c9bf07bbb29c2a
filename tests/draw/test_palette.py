"""Colours of numbers."""

from __future__ import annotations

import numpy as np

from igl_spheremap.draw.palette import colours


def test_colours_of_anything():
    for values in (np.zeros(5), np.array([np.nan, np.inf, -np.inf, 0, 1]), np.full(3, np.nan)):
        assert all(channel.dtype == np.uint8 for channel in colours(values).values())
