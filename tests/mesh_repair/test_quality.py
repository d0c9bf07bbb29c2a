"""The figures of a mesh are those of exact bodies, in any units, and planted faults are counted."""

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.mesh_repair.quality import mesh_quality
from igl_spheremap.operators.laplacian import build_operators

OCTAHEDRON = np.vstack([np.eye(3), -np.eye(3)])
OCTAHEDRON_FACES = np.array(
    [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
)


@pytest.mark.parametrize("scale", [1e-7, 1.0, 1e5])
def test_an_octahedron_in_any_units(scale):
    quality = mesh_quality(scale * OCTAHEDRON + scale, OCTAHEDRON_FACES)
    assert quality.area == pytest.approx(4 * np.sqrt(3) * scale**2)
    assert quality.volume == pytest.approx(4 / 3 * scale**3)
    assert quality.extent == pytest.approx((2 * scale,) * 3)
    assert quality.shortest_edge == pytest.approx(np.sqrt(2) * scale)
    assert (quality.smallest_angle, quality.largest_angle) == pytest.approx((60, 60))
    assert (quality.largest_valence, quality.non_delaunay_edges, quality.zero_area_faces) == (
        4,
        0,
        0,
    )
    inside_out = mesh_quality(scale * OCTAHEDRON, OCTAHEDRON_FACES[:, ::-1])
    assert inside_out.volume == pytest.approx(-4 / 3 * scale**3)


def test_faults_are_counted():
    v, f = ism.samples.sphere(162)
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
    v, f = ism.samples.sphere(642)
    v = v * [1, 1, 6]
    weights = build_operators(ism.check_mesh(v, f)).L.tocoo()
    negative = (weights.data[weights.row < weights.col] > 1e-9).sum()
    assert mesh_quality(v, f).non_delaunay_edges == negative > 0


@pytest.mark.parametrize("unit", [1e-300, 1e104, 1e300, 8e307])
def test_areas_and_volumes_beyond_float64_are_no_errors(unit):
    v, f = ism.samples.make("spheroid", n_vertices=300)
    near, far = mesh_quality(v, f), mesh_quality(unit * v, f)
    assert far.mean_edge == pytest.approx(unit * near.mean_edge, rel=1e-9, abs=0)
    assert (far.slivers, far.non_delaunay_edges) == (near.slivers, near.non_delaunay_edges)
    assert far.volume == (0 if unit < 1 else np.inf)
