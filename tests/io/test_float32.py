"""Maps as float32 numbers: certified as they are, and moved only where rounding folds."""

from __future__ import annotations

import numpy as np
import pytest
from triangulations import icosphere, unit

from igl_spheremap import samples, spherical_conformal_map
from igl_spheremap.io.float32 import certified_float32
from igl_spheremap.verify.certificate import certify


@pytest.fixture(scope="module")
def arms():
    """An octopus and its map, without foldings in float64."""
    v, f = samples.make("octopus", n_vertices=3000, arm_length=3.0)
    return f, spherical_conformal_map(v, f).sphere


@pytest.mark.parametrize("radius", [1.0, 100.0, 3e-3])
def test_float32_positions_are_certified_as_they_are(arms, radius):
    f, x = arms
    assert certify(x, f).folding_free
    rounded = (radius * x).astype(np.float32)
    assert certify(unit(rounded.astype(float)), f).foldings
    single = certified_float32(x, f, radius)
    assert single.positions.dtype == np.float32
    assert single.certificate.folding_free
    # the certificate is that of the very numbers: a power of two is exact to divide by
    exact = single.positions.astype(float) / 2.0 ** np.round(np.log2(radius))
    assert (certify(exact, f).foldings, certify(exact, f).degree) == (0, 1)
    stayed = np.setdiff1d(np.arange(len(x)), single.moved)
    assert (single.positions[stayed] == rounded[stayed]).all()
    assert len(stayed) > len(x) / 3


def test_float32_reports_where_it_has_no_room():
    x, f = icosphere(3)
    crowded = unit(x + 3e9)
    single = certified_float32(crowded, f)
    assert not single.certificate.folding_free


def test_limbs_whose_vertices_coincide_in_the_plane_are_rounded_too():
    v, f = samples.make("octopus", arm_length=6.0)
    single = certified_float32(spherical_conformal_map(v, f).sphere, f)
    assert single.certificate.folding_free
