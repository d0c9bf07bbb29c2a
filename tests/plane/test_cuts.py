"""A template's cuts on another mesh: connected, at the template's places, around one disk."""

from itertools import pairwise

import numpy as np
import pytest
from cortices import turned
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

import igl_spheremap as ism
from igl_spheremap.plane.cuts import carry_cuts
from igl_spheremap.samples import sphere

X, F = sphere(2562)
LOW = X[:, 2] < -0.7


def path():
    """A chain of neighbours along that meridian, one vertex wide, to the cap."""
    keys = {tuple(edge) for edge in np.sort(F[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)).tolist()}
    at = int(np.argmax(X @ np.array([0.8, 0, 0.6])))
    chain = [at]
    while not LOW[chain[-1]]:
        beside = [i + j - chain[-1] for i, j in keys if chain[-1] in (i, j)]
        chain.append(min(beside, key=lambda i: X[i, 2] + 3 * abs(X[i, 1])))
    return np.array(chain)


CHAIN = path()


@pytest.mark.parametrize("gap", [0, 1])
def test_a_cap_with_a_cut_is_carried_to_another_mesh(gap):
    """Also where the cut ends one vertex before the cap: the patch passes there twice."""
    lacks = LOW.copy()
    lacks[CHAIN[: len(CHAIN) - 1 - gap]] = True
    y, g = turned(10_242)
    edges = carry_cuts(g, y, F, X, np.flatnonzero(~lacks))
    keys = np.sort(g[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2))
    assert {*map(tuple, edges.tolist())} <= {*map(tuple, keys.tolist())}
    links = coo_matrix((np.ones(len(edges)), edges.T), shape=(len(y), len(y)))
    assert (np.bincount(connected_components(links)[1]) > 1).sum() == 1

    disk = ism.repair_disk(y, g, cut=edges, keep_largest=True)
    assert disk.v[:, 2].min() > -0.85
    twice = np.flatnonzero(np.bincount(disk.vertex_source) > 1)
    width = np.linalg.norm(X[F[:, 0]] - X[F[:, 1]], axis=1).max()
    off = np.linalg.norm(y[twice][:, None] - X[lacks | np.isin(np.arange(len(X)), CHAIN)], axis=2)
    assert off.min(axis=1).max() < width
    assert y[twice, 2].max() > X[CHAIN[0], 2] - width
    share = len(disk.f) / len(g)
    assert share == pytest.approx(1 - (1 - 0.7) / 2, abs=0.02)


def test_on_its_own_mesh_a_cut_stays_where_it_is():
    lacks = LOW.copy()
    lacks[CHAIN] = True
    edges = carry_cuts(F, X, F, X, np.flatnonzero(~lacks))
    assert lacks[edges].all()
    assert {*pairwise(CHAIN)} <= {*map(tuple, np.vstack((edges, edges[:, ::-1])).tolist())}


def test_a_hole_of_the_patch_is_no_cut_and_a_whole_patch_is_refused():
    lacks = LOW.copy()
    lacks[np.argmax(X[:, 2])] = True
    edges = carry_cuts(F, X, F, X, np.flatnonzero(~lacks))
    assert X[edges.ravel(), 2].max() < 0
    with pytest.raises(ism.MeshError, match="nothing is cut"):
        carry_cuts(F, X, F, X, np.arange(len(X)))
