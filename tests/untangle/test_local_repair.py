"""Small moves that repair slivers: enough, no more, and nothing where they do not help."""

from __future__ import annotations

import numpy as np
import pytest
from triangulations import drawn_to_pole, icosphere, unit

import igl_spheremap as ism
from igl_spheremap.mesh.edges import marked, touching
from igl_spheremap.untangle.embedding import dilate
from igl_spheremap.untangle.local_repair import small_moves
from igl_spheremap.verify.certificate import certify, orientation_signs


def _with_slivers():
    """A sphere, some faces of which have a vertex just beyond the middle of their opposite edge."""
    x, f = icosphere(4)
    rng = np.random.default_rng(0)
    for k in rng.permutation(len(f))[:12]:
        a, b, c = f[k]
        x[a] = unit((x[b] + x[c])[None] / 2 + 1e-4 * (x[b] + x[c] - 2 * x[a])[None])[0]
    return x, f


def test_slivers_stand_up_by_moves_as_small_as_they_are_thin():
    x, f = _with_slivers()
    edge = np.linalg.norm(x[f[:, 0]] - x[f[:, 1]], axis=1).mean()
    assert certify(x, f).foldings >= 10
    y = small_moves(x, f)
    assert certify(y, f).folding_free
    assert np.linalg.norm(y - x, axis=1).max() < 0.01 * edge
    assert (y != x).any(axis=1).sum() < 200


def test_slivers_beside_an_end_of_an_axis_stand_up_by_the_same_moves_at_every_scale():
    x, f = _with_slivers()
    near = x[:, 2] > 0.3
    moves = []
    for size in (2.0**-40, 2.0**-700):
        y = drawn_to_pole(x, size)
        assert certify(y, f).foldings >= 10
        moves.append((small_moves(y, f[near[f].all(axis=1)])[near, :2] - y[near, :2]) / size)
    assert moves[0].any()
    assert moves[1] == pytest.approx(moves[0], rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("seed", [321, 359, 370])
def test_nested_thin_faces_are_freed_one_after_the_other(seed):
    x, f = _nested(seed)
    before = certify(x, f)
    assert before.foldings >= 4
    assert before.degree == 1
    assert certify(small_moves(x, f), f).folding_free


def _nested(seed):
    """A side between two vertices, and others near it: each is the apex of a face over the side below the last one."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 12))
    near = np.column_stack(
        (
            rng.uniform(-0.9, 0.9, n),
            rng.normal(size=n) * 10.0 ** rng.uniform(-4, -1),
            np.ones(n),
        )
    )
    p, q, above, below, first = range(5)
    last = first + n - 1
    f = [(p, q, above), (q, p, first), (last, p, below), (q, last, below)]
    f += [(p, above, below), (above, q, below)]
    for k in range(first, last):
        f += [(k, p, k + 1), (q, k, k + 1)]
    ends = [(-1, 0, 1), (1, 0, 1), (0, 2, -1), (0, -2, -1)]
    return unit(np.vstack((ends, near))), np.array(f)


def test_a_map_without_foldings_stays_bit_for_bit():
    x, f = icosphere(3)
    assert small_moves(x, f).tobytes() == x.tobytes()


def test_what_small_moves_do_not_repair_keeps_nothing_else_folded():
    x, f = _with_slivers()
    away = np.argmin(x @ np.array([0.3, 0.5, -0.8]))
    x[away] = -x[away]  # a vertex on the other side of the sphere
    beside = np.unique(f[(f == away).any(axis=1)])
    y = small_moves(x, f)
    folded = np.unique(f[orientation_signs(y, f) <= 0])
    assert away in folded
    assert 0 < certify(y, f).foldings < certify(x, f).foldings
    assert set(beside) & set(folded)
    assert set(folded) <= set(np.unique(f[np.isin(f, beside).any(axis=1)]))


def test_a_map_in_one_point_is_survived():
    f = icosphere(1)[1]
    assert np.isfinite(small_moves(np.tile([0.0, 0.0, 1.0], (42, 1)), f)).all()
    opposite = np.tile([0.0, 0.0, 1.0], (42, 1)) * np.where(np.arange(42) % 2, 1.0, -1.0)[:, None]
    assert np.isfinite(small_moves(opposite, f)).all()


def test_the_listener_sees_every_round():
    x, f = _with_slivers()
    seen = []
    y = small_moves(x, f, seen.append)
    assert (seen[-1] == y).all()
    assert [certify(z, f).foldings for z in seen][-1] == 0


@pytest.mark.parametrize("rings", [0, 1, 3])
def test_a_patch_has_all_faces_around_its_vertices_and_a_rim_where_the_mesh_goes_on(rings):
    v, f = ism.samples.make("bird", n_vertices=900)
    chosen = np.array([5, 700, 6])
    patch = ism.check_mesh(v, f).edges.patch_around(chosen, rings)
    inside = touching(f, dilate(f, marked(chosen, len(v)), rings))
    assert np.array_equal(patch.vertices[patch.f], f[inside])
    assert np.array_equal(patch.vertices[patch.rim], np.intersect1d(f[inside], f[~inside]))
