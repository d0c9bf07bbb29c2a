"""Polygons keep their shape when they are cut: areas add up, all triangles face one way, no edge is made twice."""

from __future__ import annotations

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.mesh_repair.polygons import cut_polygons

L = np.array([(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)], dtype=float)
HOLE = np.array([(1, 1), (1, 3), (3, 3), (3, 1)], dtype=float)
SQUARE = np.array([(0, 0), (4, 0), (4, 4), (0, 4)], dtype=float)


def star(rng):
    k = int(rng.integers(5, 25))
    turn = 2 * np.pi * (np.arange(k) + rng.uniform(0, 0.8, k)) / k
    return rng.uniform(0.05, 1, k)[:, None] * np.column_stack((np.cos(turn), np.sin(turn)))


def with_collinear_corners(rng):
    corners = []
    for a, b in zip(L, np.roll(L, -1, axis=0), strict=True):
        corners += [a, *(a + np.sort(rng.uniform(0, 1, rng.integers(0, 4)))[:, None] * (b - a))]
    return np.array(corners)


def comb(rng):
    teeth = int(rng.integers(1, 8))
    x = np.arange(2 * teeth + 1)
    return np.vstack(([0, -1], [2 * teeth, -1], np.column_stack((x, x % 2))[::-1]))


SHAPES = (star, with_collinear_corners, comb)


def in_space(p, rng):
    """In a random plane, from a random corner on, and with the six digits that files keep."""
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    placed = np.column_stack((p, np.zeros(len(p)))) @ turn.T * rng.uniform(0.01, 100)
    return np.roll(placed, int(rng.integers(len(p))), axis=0).astype(np.float32).astype(float)


def normals(v, f):
    return np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]]) / 2


def assert_kept(v, f):
    """The triangles of one polygon: as many as it takes, of its area, all facing its way."""
    whole = np.cross(v - v[0], np.roll(v, -1, axis=0) - v[0]).sum(axis=0) / 2
    area = np.linalg.norm(whole)
    towards = normals(v, f) @ whole / area
    assert len(f) == len(v) - 2
    assert towards.min() > 0
    assert towards.sum() == pytest.approx(area, rel=1e-5)
    assert np.linalg.norm(normals(v, f), axis=1).sum() == pytest.approx(area, rel=1e-5)


@pytest.mark.parametrize("shape", SHAPES)
def test_areas_add_up_in_any_plane(shape):
    rng = np.random.default_rng(0)
    for _ in range(40):
        v = in_space(shape(rng), rng)
        assert_kept(v, cut_polygons(v, np.arange(len(v)), np.array([len(v)])).triangles)


def test_a_bridge_to_a_hole_is_no_corner_inside():
    for row in range(10):
        v = np.column_stack((np.vstack((SQUARE, SQUARE[:1], HOLE, HOLE[:1])), np.zeros(10)))
        v = np.roll(v, row, axis=0)
        assert_kept(v, cut_polygons(v, np.arange(10), np.array([10])).triangles)


def prism(base):
    """The polygons of a prism, outwards: bottom, top, sides."""
    k = len(base)
    v = np.vstack([np.column_stack((base, np.full(k, z))) for z in (0.0, 1.0)])
    i, j = np.arange(k), (np.arange(k) + 1) % k
    sides = np.column_stack((i, j, j + k, i + k))
    corners = np.concatenate((i[::-1], i + k, sides.ravel()))
    return v, corners, np.array([k, k] + [4] * k)


def test_an_l_prism_is_closed_and_has_its_area():
    v, corners, sizes = prism(L)
    cut = cut_polygons(v, corners, sizes)
    assert cut.concave.tolist() == [True, True] + [False] * 6
    mesh = ism.check_mesh(v, corners[cut.triangles])
    assert np.linalg.norm(normals(mesh.v, mesh.f), axis=1).sum() == pytest.approx(22)
    assert np.array_equal(cut.polygon, np.sort(cut.polygon))


@pytest.mark.parametrize("seed", range(10))
def test_prisms_over_any_shape_are_spheres(seed):
    rng = np.random.default_rng(seed)
    v, corners, sizes = prism(SHAPES[seed % 3](rng))
    ism.check_mesh(v, corners[cut_polygons(v, corners, sizes).triangles])


@pytest.mark.parametrize("turn", range(4))
def test_a_doublet_takes_the_diagonal_that_is_no_edge(turn):
    """Two quads that share two edges: their common corners must not be joined twice."""
    v = np.array([(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
    v = np.vstack((v, (0.5, 0.5, 1.1)))
    quads = np.array(
        [
            [0, 3, 2, 1],
            [0, 1, 5, 4],
            [1, 2, 6, 5],
            [2, 3, 7, 6],
            [3, 0, 4, 7],
            [4, 5, 6, 8],
            [4, 8, 6, 7],
        ]
    )
    quads = np.roll(quads, turn, axis=1)
    f = quads.ravel()[cut_polygons(v, quads.ravel(), np.full(7, 4)).triangles]
    assert len(ism.check_mesh(v, f).f) == 14


def test_a_sound_mesh_of_quads_is_cut_as_before():
    """Convex quads take the diagonal from their first corner."""
    v = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2, 1, 0)])
    cut = cut_polygons(v, np.array([0, 1, 2, 3, 1, 4, 5, 2]), np.array([4, 4]))
    assert cut.triangles.tolist() == [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]


def test_faults_of_polygons_are_left_to_the_check():
    """NaN, indices out of range, all corners at one place, a corner given twice: triangles all the same."""
    v = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (np.nan, 0, 0)])
    with np.errstate(all="ignore"):
        for face in ([0, 1, 2, 4], [0, 1, 2, 9], [0, -1, 2, 3], [1, 1, 1, 1, 1], [0, 1, 2, 2]):
            cut = cut_polygons(v, np.array(face), np.array([len(face)]))
            assert cut.triangles.shape == (len(face) - 2, 3)


def test_the_file_says_how_many_were_concave(tmp_path):
    path = tmp_path / "arrow.obj"
    path.write_text("v 1 0 0\nv 0 -.5 0\nv -1 0 0\nv 0 -2 0\nv 2 -2 0\nf 1 2 3 4\nf 1 4 5\n")
    mesh = ism.read_mesh(path, triangulate=True)
    assert (mesh.triangulated, mesh.concave) == (1, 1)
    assert mesh.f.tolist() == [[1, 2, 3], [1, 3, 0], [0, 3, 4]]
    assert (normals(mesh.v, mesh.f)[:2, 2] > 0).all()


@pytest.mark.parametrize("f", [[[0, 1, 2], [0, 2, 1]], [[0, 1, 2, 3]], [[0, 1, 2], [0, 1, 2, 3]]])
@pytest.mark.parametrize("function", [ism.info, ism.repair_mesh, ism.repair_disk])
def test_faces_of_no_vertices_are_refused(function, f):
    with pytest.raises(ism.MeshError, match="no vertices"):
        function(np.zeros((0, 3)), f)
