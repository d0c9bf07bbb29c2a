"""The mesh that most tests of files write."""

from __future__ import annotations

import numpy as np
import pytest

from igl_spheremap import samples, spherical_conformal_map


@pytest.fixture(scope="session")
def ball() -> tuple[np.ndarray, np.ndarray]:
    """Unit rows that need all their digits."""
    v, f = samples.sphere(162)
    turned = v @ np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    return turned, f


@pytest.fixture(scope="session")
def result():
    return spherical_conformal_map(*samples.make("spheroid", n_vertices=600))
