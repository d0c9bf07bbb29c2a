"""The boundary of a template's patch on another mesh: connected, at the template's places, around one disk."""

import igl
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


def patch(gap=0):
    """The sphere without the cap and the chain, which may end before the cap: there the patch passes twice."""
    lacks = LOW.copy()
    lacks[CHAIN[: len(CHAIN) - 1 - gap]] = True
    return F[~lacks[F].any(axis=1)]


@pytest.mark.parametrize("gap", [0, 1])
@pytest.mark.parametrize("size", [642, 10_242])
def test_the_boundary_of_a_patch_is_carried_to_another_mesh(size, gap):
    faces = patch(gap)
    y, g = turned(size)
    edges = carry_cuts(g, y, faces, X)
    keys = np.sort(g[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2))
    assert {*map(tuple, edges.tolist())} <= {*map(tuple, keys.tolist())}
    links = coo_matrix((np.ones(len(edges)), edges.T), shape=(len(y), len(y)))
    assert (np.bincount(connected_components(links)[1]) > 1).sum() == 1

    disk = ism.repair_disk(y, g, cut=edges, keep_largest=True)
    width = max(np.linalg.norm(x[t[:, 0]] - x[t[:, 1]], axis=1).max() for x, t in ((X, F), (y, g)))
    rim = disk.v[ism.check_disk(disk.v, disk.f).rim]
    ring = X[np.unique(igl.boundary_facets(faces)[0])]
    for some, others in ((rim, ring), (ring, rim)):
        assert np.linalg.norm(some[:, None] - others, axis=2).min(axis=1).max() < width
    assert len(disk.f) / len(g) == pytest.approx(len(faces) / len(F), abs=0.03)


def test_a_cut_narrower_than_the_faces_becomes_a_slit():
    y, g = turned(162)
    disk = ism.repair_disk(y, g, cut=carry_cuts(g, y, patch(), X), keep_largest=True)
    twice = np.flatnonzero(np.bincount(disk.vertex_source) > 1)
    width = np.linalg.norm(y[g[:, 0]] - y[g[:, 1]], axis=1).max()
    off = np.linalg.norm(y[twice][:, None] - X[CHAIN], axis=2).min(axis=1)
    assert len(off) > 1
    assert off.max() < width


@pytest.mark.parametrize("gap", [0, 1])
def test_on_its_own_mesh_the_disk_is_the_patch(gap):
    faces = patch(gap)
    disk = ism.repair_disk(X, F, cut=carry_cuts(F, X, faces, X), keep_largest=True)
    assert np.array_equal(disk.vertex_source[disk.f], faces)


def test_a_hole_of_the_patch_is_no_cut_and_a_whole_patch_is_refused():
    lacks = LOW.copy()
    lacks[np.argmax(X[:, 2])] = True
    edges = carry_cuts(F, X, F[~lacks[F].any(axis=1)], X)
    assert X[edges.ravel(), 2].max() < 0
    with pytest.raises(ism.MeshError, match="nothing is cut"):
        carry_cuts(F, X, F, X)
