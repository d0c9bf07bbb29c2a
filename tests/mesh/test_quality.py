"""Figures of a mesh against exact values, and foretold scales against those of the map."""

from __future__ import annotations

import numpy as np
import pytest

from igl_spheremap import check_mesh, samples, spherical_conformal_map
from igl_spheremap.mesh.quality import mesh_quality
from igl_spheremap.operators.limb_scale import deep_limbs, log_scale, shortest_image_edges
from igl_spheremap.operators.operators import build_operators

OCTAHEDRON = np.vstack([np.eye(3), -np.eye(3)])
FACES = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])


@pytest.mark.parametrize("scale", [1e-7, 1.0, 1e5])
def test_an_octahedron_in_any_units(scale):
    quality = mesh_quality(scale * OCTAHEDRON + scale, FACES)
    assert quality.area == pytest.approx(4 * np.sqrt(3) * scale**2)
    assert quality.volume == pytest.approx(4 / 3 * scale**3)
    assert quality.extent == pytest.approx((2 * scale,) * 3)
    assert quality.shortest_edge == pytest.approx(np.sqrt(2) * scale)
    assert (quality.smallest_angle, quality.largest_angle) == pytest.approx((60, 60))
    assert (quality.largest_valence, quality.non_delaunay_edges, quality.zero_area_faces) == (4, 0, 0)
    assert mesh_quality(scale * OCTAHEDRON, FACES[:, ::-1]).volume == pytest.approx(-4 / 3 * scale**3)


def test_faults_are_counted():
    v, f = samples.sphere(162)
    i, j, k = f[0]
    v[k] = v[i] + 0.4 * (v[j] - v[i])  # face 0 is flat, its edge ij not Delaunay
    v[f[50, 0]] = v[f[50, 1]]  # two faces at an edge of no length
    quality = mesh_quality(v, f)
    assert quality.zero_area_faces == 3
    assert quality.coincident_vertices == 1
    assert quality.shortest_edge == 0
    assert quality.slivers >= 3
    assert quality.non_delaunay_edges >= 1


def test_negative_weights_are_where_edges_are_not_delaunay():
    v, f = samples.sphere(642)
    v = v * [1, 1, 6]
    weights = build_operators(check_mesh(v, f)).L.tocoo()
    negative = (weights.data[weights.row < weights.col] > 1e-9).sum()
    assert mesh_quality(v, f).non_delaunay_edges == negative > 0


def test_foretold_scales_are_those_of_the_map():
    v, f = samples.sphere(2562)
    v = v * [1, 1, 4]
    mesh = check_mesh(v, f)
    foretold = log_scale(mesh, build_operators(mesh))
    factor = np.log(spherical_conformal_map(v, f).conformal_factor() / (4 * np.pi)) / 2
    tips = np.argsort(factor)[:100]
    assert np.abs(foretold - factor)[tips].max() < 0.6
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
