"""The landmark term."""

import numpy as np

from igl_spheremap.descent.energies.landmarks import LandmarkEnergy


def test_the_penalty_is_half_the_weighted_squared_chord():
    """A vertex that is named twice is drawn to both targets."""
    targets = np.array([[0.0, 0, 1], [0, 1, 0], [1, 0, 0]])
    value, gradient = LandmarkEnergy(np.array([1, 1, 2]), targets, np.array([2.0, 3, 0])).evaluate(np.eye(3))
    assert value == (2 * 2 + 3 * 0) / 2
    assert np.array_equal(gradient, [[0, 0, 0], [0, 2, -2], [0, 0, 0]])
