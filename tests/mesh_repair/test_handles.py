"""Handles are found where they are, cut along loops that can't be shorter, and closed; holes before them."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from triangulations import delaunay_sphere

import igl_spheremap as ism
from igl_spheremap.mesh.check import check_faces
from igl_spheremap.mesh_repair.handles import cutting_loops, short_loop


def torus(n, k, r, rng=None):
    """A torus of radii 1 and r, n vertices along and k around it; positions are moved at random if asked for."""
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(k), indexing="ij"))
    a, b = 2 * np.pi * i / n, 2 * np.pi * j / k
    v = np.column_stack(
        ((1 + r * np.cos(b)) * np.cos(a), (1 + r * np.cos(b)) * np.sin(a), r * np.sin(b))
    )
    if rng is not None:
        v = v + 0.02 * rng.normal(size=v.shape)

    def at(i, j):
        return i % n * k + j % k

    f = np.vstack(
        (
            np.column_stack((at(i, j), at(i + 1, j), at(i + 1, j + 1))),
            np.column_stack((at(i, j), at(i + 1, j + 1), at(i, j + 1))),
        )
    )
    return v, f


def shortest_on_torus(v, n, k):
    """Length of the shortest loop that can't be contracted, from distances on 3 x 3 sheets of the plane over it."""
    i, j = (a.ravel() for a in np.meshgrid(np.arange(3 * n), np.arange(3 * k), indexing="ij"))
    rows, columns, lengths = [], [], []
    for di, dj in ((1, 0), (0, 1), (1, 1)):
        inside = (i + di < 3 * n) & (j + dj < 3 * k)
        a, b = i[inside], j[inside]
        rows.append(a * 3 * k + b)
        columns.append((a + di) * 3 * k + b + dj)
        lengths.append(
            np.linalg.norm(v[a % n * k + b % k] - v[(a + di) % n * k + (b + dj) % k], axis=1)
        )
    entries = (np.concatenate(lengths), (np.concatenate(rows), np.concatenate(columns)))
    graph = coo_matrix(entries, shape=(9 * n * k,) * 2)
    best = np.inf
    for start in [(n + s, k) for s in range(n)] + [(n, k + s) for s in range(k)]:
        distance = dijkstra(
            graph.tocsr(), directed=False, indices=start[0] * 3 * k + start[1]
        ).reshape(3 * n, 3 * k)
        for di, dj in ((1, 0), (0, 1), (1, 1), (1, -1)):
            best = min(
                best,
                distance[start[0] + di * n if start[0] + di * n < 3 * n else 0, start[1] + dj * k]
                if start[0] + di * n < 3 * n and 0 <= start[1] + dj * k < 3 * k
                else np.inf,
            )
    return best


def length(v, loop):
    return np.linalg.norm(v[loop] - v[np.roll(loop, -1)], axis=1).sum()


def cut(v, f, **options):
    """The repaired mesh, after checks that hold for any: a sphere, with the surface's faces and positions."""
    mesh = ism.repair_mesh(v, f, handles="cut", **options)
    ism.check_mesh(mesh.v, mesh.f)
    kept, known = mesh.face_source >= 0, mesh.vertex_source >= 0
    assert np.array_equal(mesh.face_source[kept], np.arange(len(f)))
    assert np.array_equal(mesh.v[known], v[mesh.vertex_source[known]])
    assert np.array_equal(np.sort(mesh.vertex_source[mesh.f[kept]], axis=1), np.sort(f, axis=1))
    assert np.array_equal(mesh.vertex_image, np.arange(len(v)))
    assert (mesh.vertex_source[mesh.f[~kept]] >= 0).any(axis=1).any()
    return mesh


@pytest.mark.parametrize("inward", [False, True])
@pytest.mark.parametrize(
    ("r", "kind", "around"), [(0.3, "handle", 2 * np.pi * 0.3), (0.8, "tunnel", 2 * np.pi * 0.2)]
)
def test_the_shorter_of_tunnel_and_handle_is_cut(r, kind, around, inward):
    v, f = torus(48, 36, r)
    mesh = ism.repair_mesh(v, f[:, ::-1], handles="cut") if inward else cut(v, f)
    told = re.match(
        r"cut 1 handle, a (\w+) loop of (\d+) edges and length ([\d.]+) near \(.*\)",
        mesh.actions[0],
    )
    assert told[1] == kind
    assert float(told[3]) == pytest.approx(around, rel=0.02)
    assert len(mesh.v) - (mesh.vertex_source < 0).sum() == len(v) + int(told[2])
    assert ism.spherical_conformal_map(
        mesh.v, mesh.f, caps=mesh.face_source < 0
    ).certificate.folding_free


@pytest.mark.parametrize("seed", range(8))
def test_loops_are_the_shortest_of_a_torus(seed):
    rng = np.random.default_rng(seed)
    n, k = rng.integers(6, 16, 2)
    v, f = torus(n, k, rng.uniform(0.2, 0.7), rng)
    shortest = shortest_on_torus(v, n, k)
    (loop,) = cutting_loops(v, f)
    assert shortest * (1 - 1e-9) <= length(v, loop) <= 1.01 * shortest
    assert length(v, short_loop(v, f)) <= 1.5 * shortest


def handles_added(v, f, k, rng):
    """The mesh with k pairs of faces replaced by tubes, and the corners of the tubes' rims."""
    edges = {
        tuple(sorted(face[m] for m in pair))
        for face in f.tolist()
        for pair in ((0, 1), (1, 2), (2, 0))
    }
    f, used, rims = f.tolist(), set(), []
    while len(rims) < k:
        i, j = rng.choice(len(f), 2, replace=False)
        a, b = f[i], f[j]
        if (
            len(set(a + b)) < 6
            or used & set(a + b)
            or any(tuple(sorted((p, q))) in edges for p in a for q in b)
        ):
            continue
        used |= set(a + b)
        rims.append((a, b))
        f = [face for m, face in enumerate(f) if m not in (i, j)]
        b = b[::-1]
        f += [[a[m], a[(m + 1) % 3], b[(m + 1) % 3]] for m in range(3)]
        f += [[a[m], b[(m + 1) % 3], b[m]] for m in range(3)]
    return v, np.array(f), rims


@pytest.mark.parametrize("seed", range(3))
def test_random_handles_and_holes(seed):
    """Fifty handles and up to as many holes on each of three bodies, twice: each handle is found, and none else."""
    rng = np.random.default_rng(seed)
    v, f = delaunay_sphere(int(rng.integers(700, 1000)), rng)
    k = 50
    v, f, _ = handles_added(v, f, k, rng)
    with pytest.raises(
        ism.MeshError,
        match=rf"genus {k}: {k} handles \(the shortest loop found has 3 edges, near \(",
    ):
        ism.check_mesh(v, f)
    mesh = cut(v, f)
    assert re.match(rf"cut {k} handles, a \w+ loop of 3 edges", mesh.actions[-1])
    drop = rng.choice(np.arange(len(f) - 6 * k), int(rng.integers(1, 50)), replace=False)
    left = np.delete(f, drop, axis=0)
    if len(np.unique(left)) < len(v):
        return
    with pytest.raises(
        ism.MeshError, match=r"\(repair_mesh\(v, f, .*holes='fill', handles='cut'\) does\)"
    ):
        ism.check_mesh(v, left)
    assert cut(v, left, holes="fill").actions[0].startswith("filled")


def test_a_loop_that_separates_is_none():
    """Two bodies that a thin neck joins: no loop is shorter than the neck's, and it is not cut."""
    v, f = torus(24, 16, 0.4)
    face = f[0]
    far = f + len(v)
    other = far[0][::-1]
    neck = np.array(
        [[face[m], face[(m + 1) % 3], other[(m + 1) % 3]] for m in range(3)]
        + [[face[m], other[(m + 1) % 3], other[m]] for m in range(3)]
    )
    both = np.vstack((v, v + 0.01))
    loops = cutting_loops(both, np.vstack((f[1:], far[1:], neck)))
    assert loops
    for loop in loops:
        assert length(both, loop) == pytest.approx(2 * np.pi * 0.4, rel=0.05)
    mesh = cut(both, np.vstack((f[1:], far[1:], neck)))
    assert "cut 2 handles" in mesh.actions[-1]


def test_the_place_of_a_handle_is_told():
    """A ball with one tube through it: the loop is at the tube."""
    v, f = delaunay_sphere(600, np.random.default_rng(1))
    v, f, ((a, b),) = handles_added(v, f, 1, np.random.default_rng(2))
    with pytest.raises(ism.MeshError, match="genus 1: 1 handle") as caught:
        ism.check_mesh(10 * v, f)
    where = np.array(
        [float(x) for x in str(caught.value).split("near (")[1].split(")")[0].split(",")]
    )
    assert min(np.linalg.norm(where - 10 * v[rim].mean(axis=0)) for rim in (a, b)) < 1
    with pytest.raises(ism.MeshError, match=r"genus 1: 1 handle \(Euler characteristic 0\)"):
        check_faces(f, len(v))


def test_what_was_asked_for_is_in_the_call_that_helps():
    v, f = torus(12, 8, 0.4)
    with pytest.raises(
        ism.MeshError, match=r"repair_mesh\(v, f, holes='fill', handles='cut'\) does"
    ):
        ism.repair_mesh(v, f[1:], holes="fill")
    with pytest.raises(
        ism.MeshError,
        match=r"open surface: .*repair_mesh\(v, f, holes='fill', handles='cut'\) does",
    ):
        ism.repair_mesh(v, f[1:], handles="cut")
    two = np.vstack((f, f + len(v)))
    with pytest.raises(
        ism.MeshError, match=r"2 components.*\(v, f, keep_largest=True, handles='cut'\) does"
    ):
        ism.repair_mesh(np.vstack((v, v + 5)), two, handles="cut")
    assert (
        "cut 1 handle"
        in ism.repair_mesh(np.vstack((v, v + 5)), two, keep_largest=True, handles="cut").actions[-1]
    )
    with pytest.raises(ValueError, match="handles is 'fill'"):
        ism.repair_mesh(v, f, handles="fill")


def test_units_and_zero_lengths_change_no_topology():
    v, f = torus(20, 10, 0.3)
    for w in (1e-9 * v, 1e12 * v, v * [1, 1, 0], v * [1, 0, 0]):
        assert "cut 1 handle" in cut(w, f).actions[-1]


@pytest.mark.parametrize("unit", [2.0**-996, 1e-160, 1e-12, 1e20, 1e39, 1e200, 1e300])
@pytest.mark.parametrize("r", [0.35, 0.8])
def test_a_handle_is_cut_alike_in_all_units(unit, r):
    """A library takes positions for float32: they come to it in the mesh's own unit."""
    v, f = torus(8, 6, r)
    f = f[3:]
    mesh, far = (ism.repair_mesh(scale * v, f, holes="fill", handles="cut") for scale in (1, unit))
    assert np.array_equal(mesh.f, far.f)
    assert np.allclose(mesh.v, far.v / unit, rtol=1e-12, atol=1e-12)
    kinds = [
        re.findall("(?:handle|tunnel) loop of [0-9]+ edges", each.actions[-1])
        for each in (mesh, far)
    ]
    assert kinds[0] == kinds[1] != []


@pytest.mark.parametrize("seed", [16, 22, 72, 80, 121, 133])  # where rims do
def test_a_torus_of_which_many_faces_are_missing_is_repaired(seed):
    """Where a rim passes two vertices in turn, the caps that meet there must leave no pinched vertex."""
    rng = np.random.default_rng(seed)
    v, f = torus(int(rng.integers(3, 14)), int(rng.integers(3, 10)), 0.4)
    f = f[rng.random(len(f)) > rng.uniform(0.1, 0.5)]
    mesh = ism.repair_mesh(v, f, keep_largest=True, holes="fill", handles="cut")
    ism.check_mesh(mesh.v, mesh.f)


def test_faces_that_are_all_degenerate_are_refused_whatever_is_asked():
    for options in (
        {},
        {"keep_largest": True},
        {"keep_largest": True, "holes": "fill", "handles": "cut"},
    ):
        with pytest.raises(ism.MeshError, match=r"repeated index.* no face is left"):
            ism.repair_mesh(np.eye(3), [[0, 0, 1], [2, 1, 2]], **options)
        with pytest.raises(ism.MeshError, match=r"1 vertex with NaN .* no face is left"):
            ism.repair_mesh(np.diag([1, np.nan, 1]), [[0, 1, 2]], **options | {"holes": "fill"})
