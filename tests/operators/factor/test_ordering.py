"""Orders are permutations, dissections separate, and both keep the fill down whatever the numbering."""

import igl
import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.csgraph import shortest_path
from scipy.sparse.linalg import splu

from igl_spheremap.operators.factor.graph_sphere import aggregate, graph_sphere
from igl_spheremap.operators.factor.ordering import (
    bandwidth_order,
    breadth_first,
    nested_dissection,
)
from igl_spheremap.operators.laplacian import laplacian


def ellipsoid(n_subdivisions=4, shuffle=None):
    v, f = igl.loop(*igl.icosahedron(), n_subdivisions)
    v = v / np.linalg.norm(v, axis=1)[:, None] * [1.0, 1.5, 3.0]
    if shuffle is not None:
        order = np.random.default_rng(shuffle).permutation(len(v))
        v, f = v[order], np.argsort(order)[f]
    return np.ascontiguousarray(v), np.ascontiguousarray(f)


def regularised(v, f):
    return (laplacian(v, f) + 1e-9 * sp.eye_array(len(v))).tocsr()


def fill(P, order, rule="NATURAL"):
    Q = P[order][:, order].tocsc()
    return splu(Q, permc_spec=rule, diag_pivot_thresh=0.0, options={"SymmetricMode": True}).nnz


@pytest.mark.parametrize("leaf", [1, 12, 10_000])
def test_orders_are_permutations(leaf):
    P = regularised(*ellipsoid(3))
    everything = np.arange(P.shape[0])
    assert (np.sort(nested_dissection(P, leaf=leaf).order) == everything).all()
    assert (np.sort(bandwidth_order(P)) == everything).all()
    assert (np.sort(breadth_first(P)) == everything).all()


@pytest.mark.parametrize("n", [1, 2, 5])
def test_tiny_and_disconnected_graphs(n):
    tree = nested_dissection(sp.eye_array(n).tocsr())
    assert sorted(tree.order.tolist()) == list(range(n))


def test_no_edge_joins_the_two_sides_of_a_separator():
    P = regularised(*ellipsoid())
    tree = nested_dissection(P)
    Q = P[tree.order][:, tree.order].tocoo()
    top = np.maximum(tree.height[Q.row], tree.height[Q.col])
    assert (tree.path[Q.row] >> top == tree.path[Q.col] >> top).all()


def test_halves_are_balanced():
    tree = nested_dissection(regularised(*ellipsoid()))
    sides = np.bincount(tree.path >> (tree.depth - 1))
    assert sides.min() > 0.4 * sides.sum()


def test_top_separator_is_of_the_order_of_a_great_circle():
    P = regularised(*ellipsoid(5))
    tree = nested_dissection(P)
    assert np.count_nonzero(tree.height == tree.depth) < 2.5 * np.sqrt(P.shape[0])


def test_breadth_first_search_ends_at_the_first_vertex_and_never_moves_away_from_it():
    P = regularised(*ellipsoid(4, shuffle=0))
    distance = shortest_path(P, unweighted=True, indices=0)[breadth_first(P)]
    assert distance[-1] == 0
    assert (np.diff(distance) <= 0).all()


@pytest.mark.parametrize("shuffle", [None, 0, 1])
def test_minimum_degree_after_breadth_first_search_fills_as_little(shuffle):
    P = regularised(*ellipsoid(5, shuffle))
    expected = fill(P, bandwidth_order(P), "MMD_AT_PLUS_A")
    assert fill(P, breadth_first(P), "MMD_AT_PLUS_A") < 1.05 * expected


@pytest.mark.parametrize("shuffle", [None, 0, 1])
def test_fill_stays_near_that_of_minimum_degree(shuffle):
    P = regularised(*ellipsoid(5, shuffle))
    minimum_degree = fill(P, bandwidth_order(P), "MMD_AT_PLUS_A")
    assert fill(P, nested_dissection(P).order) < 1.15 * minimum_degree


def test_deterministic():
    P = regularised(*ellipsoid())
    assert (nested_dissection(P).order == nested_dissection(P.copy()).order).all()


def test_aggregates_are_connected_and_small():
    P = regularised(*ellipsoid())
    labels, count = aggregate(P)
    edges = P.tocoo()
    within = labels[edges.row] == labels[edges.col]
    pieces = sp.coo_array(
        (edges.data[within] != 0, (edges.row[within], edges.col[within])), shape=P.shape
    )
    assert sp.csgraph.connected_components(pieces, directed=False)[0] == count
    assert P.shape[0] / 12 < count < P.shape[0] / 4


def test_graph_sphere_keeps_neighbours_together():
    P = regularised(*ellipsoid(5))
    P.data[:] = 1.0
    x = graph_sphere(P)
    edges = P.tocoo()
    np.testing.assert_allclose(np.linalg.norm(x, axis=1), 1.0, rtol=1e-12)
    assert np.median(np.linalg.norm(x[edges.row] - x[edges.col], axis=1)) < 4.0 / np.sqrt(
        P.shape[0]
    )
    assert np.abs(x.mean(axis=0)).max() < 0.5


@pytest.mark.parametrize("size", [1, 3])
def test_graph_sphere_places_graphs_of_hundreds_of_pieces(size):
    """What is left of a mesh without its hubs may be that."""
    x = graph_sphere(sp.block_diag([sp.coo_array(np.ones((size, size)))] * 400, format="csr"))
    assert x.shape == (400 * size, 3)
    assert np.isfinite(x).all()


def wheels(n, hubs):
    """Strips of n vertices that end in each other, whose every vertex is a neighbour of a hub, one for each part."""
    i = np.arange(n)
    ends = np.concatenate((i, i, i)), np.concatenate(((i + 1) % n, (i + 2) % n, n + i * hubs // n))
    A = sp.coo_matrix((np.ones(3 * n), ends), shape=(n + hubs, n + hubs)).tocsr()
    A = A + A.T
    return (sp.diags_array(np.asarray(A.sum(axis=1)).ravel() + 1) - A).tocsr()


@pytest.mark.parametrize("hubs", [1, 2, 20])
@pytest.mark.parametrize("shuffle", [None, 0])
def test_hubs_fill_no_more_than_others(hubs, shuffle):
    """A vertex with thousands of neighbours separates; its neighbours in its place would fill the factor."""
    P = wheels(6000, hubs)
    if shuffle is not None:
        order = np.random.default_rng(shuffle).permutation(P.shape[0])
        P = P[order][:, order].tocsr()
    assert fill(P, nested_dissection(P).order) < 20 * P.shape[0]
