"""Progressive embedding: whatever comes in, a certified bijection comes out."""

from __future__ import annotations

import numpy as np
import pytest
from triangulations import (
    bad_positions,
    delaunay_sphere,
    drawn_to_pole,
    flip_edges,
    icosphere,
    random_triangulation,
    stacked_sphere,
    unit,
)

from igl_spheremap.sphere.rows import unit_rows
from igl_spheremap.untangle.collapse import ProgressiveMesh, _Adjacency
from igl_spheremap.untangle.embedding import (
    clusters,
    embed_locally,
    embed_nearby,
    progressive_embedding,
)
from igl_spheremap.untangle.kernel import analytic_centres, centres_beside, stars_of
from igl_spheremap.verify.certificate import certify, orientation_signs


@pytest.mark.parametrize("seed", range(100))
def test_any_positions_of_any_triangulation_come_back_certified(seed):
    rng = np.random.default_rng(seed)
    f = random_triangulation(rng)
    y = progressive_embedding(bad_positions(f.max() + 1, rng), f)
    assert certify(y, f).folding_free


def test_a_bijection_comes_back_bit_for_bit():
    x, f = delaunay_sphere(400, np.random.default_rng(1))
    assert certify(x, f).folding_free
    assert progressive_embedding(x, f).tobytes() == unit_rows(x).tobytes() == x.tobytes()


def test_only_vertices_near_a_planted_folding_move():
    x, f = icosphere(4)
    folded = x.copy()
    folded[0] = unit(x[:1] + 4 * (x[f[(f == 0).any(axis=1)][0]].mean(axis=0) - x[0]))[0]
    assert certify(folded, f).foldings
    y = progressive_embedding(folded, f)
    assert certify(y, f).folding_free
    moved = np.flatnonzero((y != folded).any(axis=1))
    assert len(moved) <= 12
    assert np.linalg.norm(x[moved] - x[0], axis=1).max() < 0.35


def _folded_near_and_deep():
    """A sphere on which a vertex lies beyond a neighbour, and a cap at the other end lies beside its place."""
    x, f = icosphere(5)
    cap = x[:, 2] < -0.9
    y = x.copy()
    y[cap] = unit(x[cap] + [0.6, 0.0, 0.0])
    at = int(np.argmax(x[:, 2]))
    y[at] = unit(x[at : at + 1] + 4 * (x[f[(f == at).any(axis=1)][0]].mean(axis=0) - x[at]))[0]
    return x, y, f


def test_clusters_share_out_the_folded_faces_by_what_joins_them():
    x, y, f = _folded_near_and_deep()
    bad = orientation_signs(y, f) <= 0
    apart = clusters(f, bad)
    assert (np.sum(apart, axis=0) == bad).all()
    height = [x[f[each], 2] for each in apart]
    assert sorted(float(np.sign(h.mean())) for h in height) == [-1, 1]
    assert len(clusters(f, (f == f[0, 0]).any(axis=1))) == 1


def test_a_cluster_that_needs_more_room_leaves_all_between_it_and_another_in_place():
    x, y, f = _folded_near_and_deep()
    assert embed_nearby(y, f) is y
    z = embed_locally(y, f)
    assert certify(z, f).folding_free
    between = np.abs(x[:, 2]) < 0.3
    assert (z[between] == y[between]).all()
    near = x[:, 2] > 0.5
    assert 0 < (z[near] != y[near]).any(axis=1).sum() <= 12


def test_a_folding_beside_an_end_of_an_axis_is_repaired_alike_at_every_scale():
    x, f = icosphere(4)
    at = int(np.argmin(np.abs(x[:, 2] - 0.8)))
    x[at] = unit(x[at : at + 1] + 4 * (x[f[(f == at).any(axis=1)][0]].mean(axis=0) - x[at]))[0]
    repaired = []
    for size in (2.0**-40, 2.0**-700):
        y = drawn_to_pole(x, size)
        assert 0 < certify(y, f).foldings < 10
        z = progressive_embedding(y, f)
        assert certify(z, f).folding_free
        assert (y != z).any(axis=1).sum() <= 12
        repaired.append(z[x[:, 2] > 0.3, :2] / size)
    assert repaired[1] == pytest.approx(repaired[0], rel=1e-9)


def test_what_is_put_back_returns_to_where_it_was():
    x, f = icosphere(4)
    folded = x.copy()
    folded[0] = -x[0]  # drags its faces across the whole sphere
    y = progressive_embedding(folded, f)
    assert certify(y, f).folding_free
    moved = np.flatnonzero((y != folded).any(axis=1))
    assert len(moved) <= 7
    assert 0 in moved


def test_points_inside_a_kernel_are_taken_as_they_are_and_others_approached():
    x, f = icosphere(3)
    star = stars_of(f, np.arange(len(x)) == 40)
    target = star.a[:1]
    inside = unit(x[40:41] + 0.1 * (x[target] - x[40:41]))
    assert (centres_beside(x, star, target, inside) == inside).all()
    for outside in (x[star.a[2:3]] * 2 - x[40:41], -x[40:41]):
        y = x.copy()
        y[40] = centres_beside(x, star, target, unit(outside))[0]
        assert certify(y, f).folding_free
    centre = centres_beside(x, star, target)
    nearer = centres_beside(x, star, target, unit(x[star.a[2:3]] * 2 - x[40:41]))
    assert np.linalg.norm(nearer - x[star.a[2]]) < np.linalg.norm(centre - x[star.a[2]])


def test_a_mirrored_map_and_a_double_cover_are_rebuilt():
    x, f = icosphere(3)
    assert certify(-x, f).degree == -1
    assert certify(progressive_embedding(-x, f), f).folding_free
    doubled, f = _double_cover(24, 15)
    assert (orientation_signs(doubled, f) > 0).all()
    assert certify(doubled, f).degree == 2
    assert certify(progressive_embedding(doubled, f), f).folding_free


def _double_cover(around, along):
    """Latitude-longitude sphere whose longitudes are doubled: no folding, branched at the poles."""
    turn = 4 * np.pi * np.arange(around) / around
    height = np.linspace(-1, 1, along + 2)[1:-1, None]
    rim = np.sqrt(1 - height**2)
    x = np.stack(
        np.broadcast_arrays(rim * np.cos(turn), rim * np.sin(turn), height), axis=2
    ).reshape(-1, 3)
    x = np.vstack((x, [[0, 0, -1], [0, 0, 1]]))
    i, j = np.meshgrid(np.arange(along - 1), np.arange(around), indexing="ij")
    a, b = (around * i + j).ravel(), (around * i + (j + 1) % around).ravel()
    ring = np.arange(around)
    south, top = np.full(around, around * along), around * (along - 1)
    north = south + 1
    f = np.vstack(
        (
            np.column_stack((a, b, b + around)),
            np.column_stack((a, b + around, a + around)),
            np.column_stack((south, (ring + 1) % around, ring)),
            np.column_stack((north, top + ring, top + (ring + 1) % around)),
        )
    )
    return x, f


def test_the_same_input_gives_the_same_bits():
    rng = np.random.default_rng(3)
    f = stacked_sphere(200, rng)
    x = rng.normal(size=(200, 3))
    assert (
        progressive_embedding(x, f).tobytes() == progressive_embedding(x.copy(), f.copy()).tobytes()
    )


def test_collapses_keep_a_sphere_down_to_the_tetrahedron_and_are_undone():
    rng = np.random.default_rng(5)
    f = flip_edges(icosphere(2)[1], 2000, rng)
    n = f.max() + 1
    mesh = ProgressiveMesh(f, unit(rng.normal(size=(n, 3))), np.zeros(n, dtype=bool), unit_rows)
    batches = []
    while (batch := mesh.next_batch(np.ones(n, dtype=bool))) is not None:
        mesh.collapse(batch)
        batches.append(batch)
        left = mesh.f[mesh.faces()]
        edges = np.sort(left[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
        assert len(left) == 2 * mesh.present.sum() - 4
    assert mesh.present.sum() == 4
    for batch in reversed(batches):
        mesh.restore(batch)
    assert (np.sort(mesh.f, axis=1) == np.sort(f, axis=1)).all()


def test_common_neighbours_agree_with_sets():
    f = random_triangulation(np.random.default_rng(8))
    n = f.max() + 1
    neighbours = [set(f[(f == v).any(axis=1)].ravel()) - {v} for v in range(n)]
    u, w = f[:, 0], f[:, 1]
    expected = [len(neighbours[a] & neighbours[b]) for a, b in zip(u, w, strict=True)]
    assert _Adjacency(f, n).common(u, w).tolist() == expected


def _polygon_star(radii, size):
    """A vertex at the north pole within a polygon about it."""
    turn = 2 * np.pi * np.arange(len(radii)) / len(radii)
    ring = np.column_stack((radii * np.cos(turn), radii * np.sin(turn))) * size
    x = unit(np.column_stack((np.vstack(([[0, 0]], ring)), np.ones(len(radii) + 1))))
    i = np.arange(len(radii))
    f = np.column_stack((np.zeros_like(i), i + 1, (i + 1) % len(radii) + 1))
    chosen = np.zeros(len(x), dtype=bool)
    chosen[0] = True
    return x, stars_of(f, chosen)


@pytest.mark.parametrize("size", [0.5, 1e-6, 1e-13, 1e-60])
def test_the_centre_of_a_regular_star_is_found_at_every_scale(size):
    x, star = _polygon_star(np.ones(7), size)
    x[0] = unit(np.array([[0.4 * size, 0.3 * size, 1.0]]))[0]
    centre = analytic_centres(x, star)[0]
    assert np.hypot(centre[0], centre[1]) < (1e-6 if size < 1e-3 else 0.2) * size


@pytest.mark.parametrize("size", [0.5, 1e-6, 1e-12, 1e-60])
def test_a_corner_that_sees_the_star_leads_to_its_kernel(size):
    radii = np.array([1.0, 0.2, 1.0, 0.3, 1.0, 0.25, 1.0, 0.9])
    x, star = _polygon_star(radii, size)
    tried = 0
    for target in star.a:
        fan = [(target, a, b) for a, b in zip(star.a, star.b, strict=True) if target not in (a, b)]
        if (orientation_signs(x, np.array(fan)) > 0).all():
            tried += 1
            y = x.copy()
            y[0] = centres_beside(x, star, np.array([target]))[0]
            around = np.column_stack((np.zeros_like(star.a), star.a, star.b))
            assert (orientation_signs(y, around) > 0).all()
    assert tried


def test_a_corner_sees_a_convex_star_from_everywhere():
    x, star = _polygon_star(np.ones(9), 1e-4)
    for target in star.a:
        centre = centres_beside(x, star, np.array([target]))[0]
        assert np.hypot(centre[0], centre[1]) < 1e-7
