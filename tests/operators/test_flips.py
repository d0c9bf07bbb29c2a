"""Intrinsic flips keep the surface, end on every mesh, and agree with libigl where that ends."""

import igl
import numpy as np
import pytest
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.mesh.edges import half_edges
from igl_spheremap.mesh.measure import angle_defects
from igl_spheremap.operators.flips import delaunay_triangulation
from igl_spheremap.operators.laplacian import laplacian, mollified_edge_lengths

X, F = icosphere(2)
ICOSAHEDRON = ism.samples.sphere(12)


def opposite_angles(lengths, f):
    """Of each half-edge the angle opposite, by the law of cosines, and the sum over both of its faces."""
    a, b, c = lengths.T, np.roll(lengths, -1, axis=1).T, np.roll(lengths, -2, axis=1).T
    return np.arccos(np.clip((b**2 + c**2 - a**2) / (2 * b * c), -1, 1)).T


def rough(seed, size=0.3):
    x, f = icosphere(3)
    return x * [1, 1, 3] + size * np.random.default_rng(seed).normal(size=x.shape), f


def wild(seed, exponent, x=X):
    """Rows whose lengths span twice this many orders of magnitude."""
    return x * 10 ** np.random.default_rng(seed).uniform(-exponent, exponent, size=(len(x), 1))


@pytest.mark.parametrize("seed", range(4))
def test_laplacians_are_those_of_libigls_flips(seed):
    v, f = rough(seed)
    lengths, faces = igl.intrinsic_delaunay_triangulation(mollified_edge_lengths(v, f), f)[:2]
    expected = -igl.cotmatrix_intrinsic(lengths, faces)
    assert abs(laplacian(v, f, "delaunay") - expected).max() < 1e-12 * abs(expected).max()
    assert laplacian(v, f, "delaunay").min() < 0


@pytest.mark.parametrize("seed", range(4))
def test_the_surface_stays_as_it_is(seed):
    """Its area, and the angles around each vertex."""
    v, f = rough(seed)
    before = igl.edge_lengths(v, f)
    lengths, faces = delaunay_triangulation(before, half_edges(f, len(v)))
    assert (faces != f).any()
    assert np.isclose(igl.doublearea(l=lengths).sum(), igl.doublearea(l=before).sum())
    defects = [
        angle_defects(opposite_angles(each, g), g, len(v))
        for each, g in ((before, f), (lengths, faces))
    ]
    assert np.allclose(*defects, atol=1e-7)


@pytest.mark.parametrize("seed", range(4))
def test_no_weight_is_negative(seed):
    L = laplacian(*rough(seed), "delaunay")
    L.setdiag(0)
    assert L.max() < 1e-12 * abs(L).max()


def test_a_delaunay_mesh_is_left_alone():
    lengths, faces = delaunay_triangulation(igl.edge_lengths(X, F), half_edges(F, len(X)))
    assert np.array_equal(faces, F)
    assert np.array_equal(lengths, igl.edge_lengths(X, F))


@pytest.mark.parametrize("exponent", [4, 8, 10, 12, 15, 20, 50, 150])
@pytest.mark.parametrize("mesh", [(X, F), ICOSAHEDRON], ids=["162", "12"])
def test_flips_end_where_lengths_span_many_orders_of_magnitude(mesh, exponent):
    """libigl's flips of half of these never end."""
    x, f = mesh
    for seed in range(10):
        v = wild(seed, exponent, x)
        before = mollified_edge_lengths(v / np.abs(v).max(), f)
        lengths, faces = delaunay_triangulation(before, half_edges(f, len(v)))
        assert np.isclose(
            igl.doublearea(l=lengths).sum(), igl.doublearea(l=before).sum(), rtol=1e-6
        )
        assert np.array_equal(np.unique(faces), np.arange(len(x)))


def test_bounds_end_flips_that_go_on():
    """A bipyramid over a long flat ellipse: some 20 flips a face."""
    n = 2000
    turn, i = 2 * np.pi * np.arange(n) / n, np.arange(n)
    v = np.vstack(
        (
            np.column_stack((100 * np.cos(turn), np.sin(turn), 0 * turn)),
            [[0, 0, 1e-3], [0, 0, -1e-3]],
        )
    )
    j = (i + 1) % n
    f = np.vstack((np.column_stack((i, j, 0 * i + n)), np.column_stack((j, i, 0 * i + n + 1))))
    before = mollified_edge_lengths(v, f)
    lengths, _ = delaunay_triangulation(before, half_edges(f, len(v)))
    assert np.isclose(igl.doublearea(l=lengths).sum(), igl.doublearea(l=before).sum(), rtol=1e-6)


@pytest.mark.parametrize("exponent", [10, 15, 20])
def test_maps_of_such_meshes_are_certified(exponent):
    for x, f in (ICOSAHEDRON, icosphere(1)):
        assert ism.spherical_conformal_map(wild(0, exponent, x), f).certificate.folding_free
