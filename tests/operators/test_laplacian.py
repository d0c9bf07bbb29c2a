"""Identities of the cotangent Laplacian, and the treatment of slivers."""

import igl
import numpy as np
import pytest
import scipy.sparse as sp

import igl_spheremap as ism
from igl_spheremap.operators.laplacian import is_usable, laplacian, mollified_edge_lengths

WEIGHTS = ("cotangent", "mollified", "delaunay")


def bumpy_sphere(n_subdivisions=3, amplitude=0.2):
    v, f = igl.icosahedron()
    v, f = igl.loop(v, f, n_subdivisions)
    v = v / np.linalg.norm(v, axis=1)[:, None]
    v *= (
        1.0
        + amplitude * np.cos(3.0 * v[:, :1] + 2.0 * v[:, 1:2])
        + 0.5 * amplitude * np.sin(5.0 * v[:, 2:])
    )
    return np.ascontiguousarray(v), np.ascontiguousarray(f)


def with_zero_area_faces():
    """A bumpy sphere where one vertex lies on another, and one on the middle of an edge."""
    v, f = bumpy_sphere()
    v = v.copy()
    v[f[0, 0]] = v[f[0, 1]]
    v[f[50, 0]] = (v[f[50, 1]] + v[f[50, 2]]) / 2.0
    return v, f


def test_equals_libigl():
    v, f = bumpy_sphere()
    assert abs(laplacian(v, f) + igl.cotmatrix(v, f)).max() < 1e-13


def test_dirichlet_energy_is_that_of_the_gradient():
    v, f = bumpy_sphere()
    gradient = igl.grad(v, f)
    areas = sp.diags_array(np.tile(igl.doublearea(v, f) / 2.0, 3))
    assert abs(laplacian(v, f) - gradient.T @ areas @ gradient).max() < 1e-12


@pytest.mark.parametrize("weights", WEIGHTS)
def test_symmetric_bit_for_bit_with_zero_row_sums(weights):
    L = laplacian(*bumpy_sphere(amplitude=0.4), weights)
    assert (L != L.T).nnz == 0
    assert abs(L.sum(axis=1)).max() < 1e-12


@pytest.mark.parametrize("weights", WEIGHTS)
def test_same_at_any_scale(weights):
    v, f = bumpy_sphere()
    assert abs(laplacian(1e-7 * v, f, weights) - laplacian(v, f, weights)).max() < 1e-8


@pytest.mark.parametrize("weights", WEIGHTS)
def test_positive_semidefinite(weights):
    eigenvalues = np.linalg.eigvalsh(laplacian(*bumpy_sphere(2, 0.4), weights).toarray())
    assert abs(eigenvalues[0]) < 1e-12
    assert eigenvalues[1] > 1e-3


def test_weights_that_vanish_stay_in_the_pattern():
    """The diagonals of a cube's faces have weight 0: a pattern that depends on values can't be reused."""
    v = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=np.float64)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    f = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    assert laplacian(v, f).nnz == 8 + 2 * 18


def test_mollification_leaves_a_good_mesh_alone():
    v, f = bumpy_sphere()
    assert (mollified_edge_lengths(v, f) == igl.edge_lengths(v, f)).all()
    assert abs(laplacian(v, f, "mollified") - laplacian(v, f)).max() < 1e-12


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_zero_area_faces_are_found_and_repaired():
    v, f = with_zero_area_faces()
    assert not is_usable(laplacian(v, f))
    for weights in ("mollified", "delaunay"):
        L = laplacian(v, f, weights)
        assert is_usable(L)
        assert np.linalg.eigvalsh(L.toarray())[0] > -1e-9


def test_mollified_lengths_are_strict_triangles():
    lengths = mollified_edge_lengths(*with_zero_area_faces())
    slack = lengths.sum(axis=1) - 2.0 * lengths.max(axis=1)
    assert slack.min() > 0.9e-5 * lengths.mean()


def test_delaunay_weights_are_not_negative():
    v, f = bumpy_sphere(amplitude=0.6)
    plain, flipped = laplacian(v, f), laplacian(v, f, "delaunay")
    assert (plain - sp.diags_array(plain.diagonal())).max() > 0.01  # a negative cotangent
    assert (flipped - sp.diags_array(flipped.diagonal())).max() < 1e-9


def test_delaunay_weights_equal_libigl():
    v, f = bumpy_sphere(amplitude=0.6)
    assert abs(laplacian(v, f, "delaunay") + igl.intrinsic_delaunay_cotmatrix(v, f)[0]).max() < 1e-9


@pytest.mark.parametrize(
    ("offset", "kind", "noted"),
    [(4.5e6, "f4", True), (4.5e6, "f8", False), (3.0, "f4", False), (1e5, "f4", True)],
)
def test_float32_far_from_the_origin_is_noted(offset, kind, noted):
    """A body of 1 m in coordinates of a map: float32 holds them to half a metre, float64 well enough."""
    v, f = ism.samples.make("pear", n_vertices=500)
    notes = ism.info((v / np.ptp(v) + offset).astype(kind), f).notes
    assert any("float32 and far from the origin" in note for note in notes) == noted
