"""Holes are found and closed, whatever their rims look like; the surface itself stays as it is."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from triangulations import delaunay_sphere, icosphere

import igl_spheremap as ism
from igl_spheremap.mesh.check import check_faces
from igl_spheremap.mesh.edges import rims
from igl_spheremap.mesh_repair.holes import cap, simple_rims

V, F = icosphere(3)


def filled(v, f):
    """The repaired mesh, after checks that hold for any: closed, the surface's faces and vertices kept."""
    mesh = ism.repair_mesh(v, f, holes="fill")
    ism.check_mesh(mesh.v, mesh.f)
    kept = mesh.face_source >= 0
    assert np.array_equal(mesh.face_source[kept], np.arange(len(f)))
    known = mesh.vertex_source >= 0
    assert np.array_equal(mesh.v[known], v[mesh.vertex_source[known]])
    corners = np.sort(mesh.vertex_source[mesh.f[kept]], axis=1)
    assert np.array_equal(corners, np.sort(f, axis=1))
    assert not known[mesh.f[~kept]].all() or (~kept).sum() == 0 or len(mesh.f[~kept]) > 0
    return mesh


def without(f, drop):
    """Faces but those, unless a vertex would be in none."""
    return np.delete(f, drop, axis=0)


def test_a_missing_face_is_put_back():
    mesh = filled(V, without(F, [7]))
    assert len(mesh.v) == len(V)
    assert sorted(mesh.f[-1].tolist()) == sorted(F[7].tolist())
    assert mesh.face_source[-1] == -1


def test_the_numbers_of_holes_and_edges_are_told():
    star = np.flatnonzero((F == 0).any(axis=1))
    ring = np.setdiff1d(np.flatnonzero(np.isin(F, F[star]).any(axis=1)), star)
    v, f = V[1:], without(F, star) - 1
    assert filled(v, f).actions[0].startswith(f"filled 1 hole ({len(star)} edges) near (")
    far = int(np.argmax(V @ -V[0]))
    others = np.flatnonzero((far == F).any(axis=1))
    keep = np.setdiff1d(np.arange(len(V)), [0, far])
    number = np.full(len(V), -1)
    number[keep] = np.arange(len(keep))
    f = number[without(F, np.r_[star, others])]
    assert (
        filled(V[keep], f)
        .actions[0]
        .startswith(
            f"filled 2 holes ({max(len(star), len(others))} and "
            f"{min(len(star), len(others))} edges), the longest near ("
        )
    )
    assert len(ring) > 0


def test_the_place_is_that_of_the_hole():
    hole = np.flatnonzero(V[F].mean(axis=1)[:, 2] > 0.9)
    used, f = np.unique(without(F, hole), return_inverse=True)
    with pytest.raises(
        ism.MeshError, match=r"open surface: 1 hole \(\d+ edges\) near \("
    ) as caught:
        ism.check_mesh(100 * V[used] + 7, f.reshape(-1, 3))
    where = np.array(
        [float(x) for x in str(caught.value).split("near (")[1].split(")")[0].split(",")]
    )
    assert np.linalg.norm(where - [7, 7, 7 + 90]) < 7
    assert "(repair_mesh(v, f, holes='fill') does)" in str(caught.value)


def test_faces_alone_name_no_place():
    with pytest.raises(
        ism.MeshError, match=r"1 hole \(3 edges\), e.g. edge \d+-\d+, .*holes='fill'"
    ):
        check_faces(F[1:], len(V))


def test_rims_that_touch_at_a_vertex_keep_it_one():
    """Two faces that share a vertex only: each is put back, and the vertex stays."""
    first, *others = np.flatnonzero((F == 50).any(axis=1))
    apart = next(i for i in others if len(np.intersect1d(F[i], F[first])) == 1)
    mesh = filled(V, without(F, [first, apart]))
    assert len(mesh.v) == len(V)
    assert {tuple(sorted(t)) for t in mesh.f.tolist()} == {tuple(sorted(t)) for t in F.tolist()}
    assert mesh.actions[0].startswith("filled 2 holes (3 and 3 edges)")


def test_bodies_that_touch_at_a_rim_are_two_components():
    number = np.arange(len(V)) + len(V)
    number[F[0, 0]] = F[0, 0]
    v, f = np.vstack((V, V + 5)), np.vstack((F[1:], number[F[1:]]))
    with pytest.raises(ism.MeshError, match="2 components"):
        ism.repair_mesh(v, f, holes="fill")


@pytest.mark.parametrize("seed", range(40))
def test_random_holes(seed):
    """Faces dropped at random, with rims that touch: as many pieces as stay, each a sphere again."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(30, 400))
    v, f = delaunay_sphere(n, rng)
    f = f[rng.random(len(f)) > rng.uniform(0.02, 0.35)]
    edges = np.sort(np.vstack((f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]])), axis=1)
    _, index = np.unique(edges, axis=0, return_inverse=True)
    order = np.argsort(index.ravel(), kind="stable")
    same = index.ravel()[order][1:] == index.ravel()[order][:-1]
    i, j = order[:-1][same] % len(f), order[1:][same] % len(f)
    _, label = connected_components(
        coo_matrix((np.ones(len(i)), (i, j)), shape=(len(f), len(f))), directed=False
    )
    f = f[label == np.argmax(np.bincount(label))]
    used, f = np.unique(f, return_inverse=True)
    mesh = filled(v[used], f.reshape(-1, 3))
    # on a sphere holes that touch never part a vertex
    assert (mesh.vertex_source >= 0).sum() == len(used)


@pytest.mark.parametrize("k", [3, 4, 5, 6, 9, 10, 11, 12, 20, 57, 400])
@pytest.mark.parametrize("shape", ["round", "zigzag", "slit", "point", "uneven"])
def test_caps_are_discs_that_run_once_through_their_rim(k, shape):
    turn = 2 * np.pi * np.arange(k) / k
    rng = np.random.default_rng(k)
    if shape == "uneven":
        turn = np.sort(rng.uniform(0, 2 * np.pi, k) ** 3)
    p = np.column_stack((np.cos(turn), np.sin(turn), np.zeros(k)))
    p *= {"slit": [1, 0, 0], "point": [0, 0, 0]}.get(shape, [1, 1, 1])
    if shape == "zigzag":
        p[:, 2] = (-1) ** np.arange(k)
    points, faces = cap(p, -p)
    n = k + len(points)
    assert np.isfinite(points).all()
    assert len(points) <= 8 / 3 * k
    assert set(faces.ravel().tolist()) == set(range(n))
    directed = np.vstack((faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]))
    there, back = ({tuple(e) for e in d.tolist()} for d in (directed, directed[:, ::-1]))
    assert len(there) == len(directed)
    assert there - back == {(i, (i + 1) % k) for i in range(k)}
    assert n - (len(directed) + k) // 2 + len(faces) == 1  # Euler characteristic of a disc
    if shape == "round":
        assert np.linalg.norm(points, axis=1).max(initial=0) < 1
        areas = (
            np.linalg.norm(
                np.cross(
                    *(
                        np.vstack((p, points))[faces[:, j]] - np.vstack((p, points))[faces[:, 0]]
                        for j in (1, 2)
                    )
                ),
                axis=1,
            )
            / 2
        )
        assert areas.sum() == pytest.approx(k / 2 * np.sin(2 * np.pi / k), rel=0.02)


def test_cycles_are_found_and_parted():
    assert [sorted(rim) for rim in rims(np.array([4, 5, 6, 1, 2]), np.array([5, 6, 4, 2, 1]))] in (
        [[4, 5, 6], [1, 2]],
        [[1, 2], [4, 5, 6]],
    )
    entries = list(range(9))
    parts = [part for part, _ in simple_rims(entries, [0, 1, 2, 3, 1, 4, 0, 5, 6])]
    assert sorted(e for part in parts for e in part) == entries
    assert [len(part) for part in parts] == [3, 3, 3]


def test_a_soup_with_a_hole_is_welded_and_filled():
    f = F[20:]
    v, soup = V[f].reshape(-1, 3), np.arange(3 * len(f)).reshape(-1, 3)
    with pytest.raises(ism.MeshError, match="holes='fill'"):
        ism.check_mesh(v, soup)
    actions = ism.repair_mesh(v, soup, holes="fill").actions
    assert actions[0].startswith("welded")
    assert actions[-1].startswith("filled")


def test_what_filling_does_not_mend_is_refused():
    # five triangles that make a Moebius strip
    strip = np.array([[i, (i + 1) % 5, (i + 2) % 5] for i in range(5)])
    for v, f, words in (
        (V[:5], strip, "open surface: 5 boundary edges.*close the holes$"),
        (V[:3], [[0, 1, 2]], "at least 4"),
    ):
        with pytest.raises(ism.MeshError, match=words):
            ism.repair_mesh(v, f, holes="fill")
    with pytest.raises(ism.MeshError, match=r"keep_largest=True, holes='fill'\) does"):
        ism.repair_mesh(np.vstack((V, V + 5)), np.vstack((F[1:], F[1:] + len(V))), holes="fill")
    with pytest.raises(ValueError, match="holes is 'close'"):
        ism.repair_mesh(V, F, holes="close")
