"""Predicted scales of limbs against those of the map."""

import numpy as np
import pytest

from igl_spheremap import check_mesh, samples, spherical_conformal_map
from igl_spheremap.operators.limb_scale import deep_limbs, log_scale, shortest_image_edges
from igl_spheremap.operators.operators import build_operators


def test_predicted_scales_are_those_of_the_map():
    v, f = samples.sphere(2562)
    v = v * [1, 1, 4]
    mesh = check_mesh(v, f)
    predicted = log_scale(mesh, build_operators(mesh))
    factor = np.log(spherical_conformal_map(v, f).conformal_factor() / (4 * np.pi)) / 2
    tips = np.argsort(factor)[:100]
    assert np.abs(predicted - factor)[tips].max() < 0.6
    assert factor[tips].max() < -2.5


@pytest.mark.parametrize("length", [2, 4, 8])
def test_a_cylinder_shrinks_by_two_pi_length_over_circumference(length):
    """Exactly, but for its ends: a spike of that length, a tenth as thick as its body."""
    v, f = samples.sphere(10242)
    up = v[:, 2] > 0.995
    radius = np.sqrt(1 - 0.995**2)
    tall = v.copy()
    rise = (v[up, 2] - 0.995) / 0.005
    keep = np.sqrt(1 - 0.99 * np.clip((rise - 0.9) / 0.1, 0, 1))
    tall[up, :2] *= (radius * keep / np.maximum(np.linalg.norm(v[up, :2], axis=1), 1e-12))[:, None]
    tall[up, 2] = 0.995 + length * radius * rise
    mesh = check_mesh(tall, f)
    scale = log_scale(mesh, build_operators(mesh))
    assert scale.min() == pytest.approx(-length, abs=2.5)


def test_deep_limbs_are_found_one_by_one():
    v, f = samples.sphere(2562)
    for axis in np.eye(3):
        cap = v @ axis > 0.99
        v = v + np.outer(np.where(cap, 12 * (v @ axis - 0.99) / 0.01, 0), axis)
    mesh = check_mesh(v, f)
    scale = log_scale(mesh, build_operators(mesh))
    edge = shortest_image_edges(mesh, scale)
    limbs = deep_limbs(mesh, scale, limit=1e-6)
    assert len(limbs) == 3
    assert sum(limb.vertices for limb in limbs) == (edge < 1e-6).sum()
    assert [limb.edge for limb in limbs] == sorted(limb.edge for limb in limbs)
    assert sorted(int(np.argmax(v[limb.tip])) for limb in limbs) == [0, 1, 2]
    assert deep_limbs(mesh, scale, limit=1e-300) == ()
