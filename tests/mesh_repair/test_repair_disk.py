"""Disks of surfaces that are none: holes but one filled, and closed surfaces cut open along a short tree."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

import igl_spheremap as ism

V, F = ism.samples.make("spheroid", n_vertices=500)
TOP, BOTTOM = int(V[:, 2].argmax()), int(V[:, 2].argmin())


def test_a_cut_is_the_shortest_path_and_its_vertices_are_doubled():
    disk = ism.repair_disk(V, F, cut=[TOP, BOTTOM])
    lengths = np.linalg.norm(V[F] - V[F[:, [1, 2, 0]]], axis=2).ravel()
    graph = csr_matrix((lengths, (F.ravel(), F[:, [1, 2, 0]].ravel())))
    rim = disk.v[ism.check_disk(disk).rim]
    around = np.linalg.norm(rim - np.roll(rim, 1, axis=0), axis=1).sum()
    assert around == pytest.approx(2 * dijkstra(graph, indices=TOP)[BOTTOM])
    assert np.array_equal(disk.vertex_source[: len(V)], np.arange(len(V)))
    assert np.array_equal(disk.vertex_source[disk.f], F)
    assert np.array_equal(disk.v, V[disk.vertex_source])


def test_tips_are_found_and_more_of_them_keep_lengths_better():
    v, f = ism.samples.make("spheroid", n_vertices=500)
    v = v * [1, 1, 3]
    rim = ism.check_disk(ism.repair_disk(v, f, cut=2))
    ends = rim.v[rim.rim, 2]
    assert (ends.min(), ends.max()) == (v[:, 2].min(), v[:, 2].max())
    few, more = (ism.flatten(ism.repair_disk(v, f, cut=k)) for k in (2, 4))
    assert few.certificate.folding_free
    assert more.certificate.folding_free
    assert np.abs(more.log_length_ratios()).mean() < np.abs(few.log_length_ratios()).mean()


@pytest.mark.parametrize(
    ("rim", "kept"), [(None, TOP), (TOP, TOP), (V[BOTTOM], BOTTOM), (BOTTOM, BOTTOM)]
)
def test_all_holes_but_one_are_filled(rim, kept):
    """A large hole at the top, a small one at the bottom."""
    around = np.unique(F[(F == TOP).any(axis=1)])
    f = F[~np.isin(F, [*around, BOTTOM]).any(axis=1)]
    with pytest.raises(
        ism.MeshError, match=r"2 boundary loops.*\(repair_disk\(v, f, holes='fill'\) does\)$"
    ) as caught:
        ism.repair_disk(V, f)
    assert caught.value.remedy.options == {"holes": "fill"}
    disk = ism.check_disk(ism.repair_disk(V, f, holes="fill", rim=rim))
    assert np.linalg.norm(disk.v[disk.rim] - V[kept], axis=1).max() < 1
    assert disk.caps.any()


def test_what_is_no_disk_has_a_remedy_that_makes_one():
    for v, f in (
        (V, F),
        (V, np.vstack((F, F[:1, ::-1]))),
        (np.vstack((V, V + 9)), np.vstack((F, F + len(V)))),
    ):
        with pytest.raises(ism.MeshError) as caught:
            ism.flatten(v, f)
        assert ism.check_disk(ism.repair_disk(v, f, **caught.value.remedy.options)).rim.size > 3


def test_wrong_cuts_are_one_sentence():
    near = [int(F[0, 0]), int(F[0, 1])]
    with pytest.raises(ism.MeshError, match="points of the cut are neighbours"):
        ism.repair_disk(V, F, cut=near)
    assert ism.repair_disk(V, F[1:], cut=2, holes="fill").caps.sum() == 1
    for options, words in (
        ({"cut": [0, len(V)]}, "two or more of the vertices"),
        ({"cut": 1}, "cut is 1; give 2"),
        ({"rim": len(V)}, "rim is"),
        ({"rim": [0, 1]}, "a point of three"),
        ({"handles": "cut"}, "goes with cut"),
    ):
        with pytest.raises(ValueError, match=words):
            ism.repair_disk(V, F, **options)


def tube(n, k, loops):
    """A cylinder of n vertices around and k rings; single faces are missing, so that it has that many loops."""
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(k), indexing="ij"))
    v = np.column_stack((np.cos(2 * np.pi * i / n), np.sin(2 * np.pi * i / n), 0.3 * j))
    a, b = (i * k + j)[j < k - 1], ((i + 1) % n * k + j)[j < k - 1]
    f = np.concatenate((np.column_stack((a, b, b + 1)), np.column_stack((a, b + 1, a + 1))))
    return v, np.delete(f, 4 + 3 * (k - 1) * np.arange(loops - 2), axis=0)


@pytest.mark.parametrize("loops", [2, 3, 5])
def test_a_cut_joins_boundary_loops_along_shortest_paths(loops):
    """So that a tube unrolls without distortion; further tips lengthen the cut."""
    v, f = tube(24, 9, loops)
    with pytest.raises(ism.MeshError, match=rf"join them by a cut \(.*cut={loops}\) does\)"):
        ism.check_disk(v, f)
    disk = ism.repair_disk(v, f, cut=2)
    assert re.fullmatch(rf"cut along \d+ edges? between {loops} boundary loops", disk.actions[-1])
    assert disk.caps is None
    if loops == 2:
        assert disk.actions[-1].startswith("cut along 8 edges")
        flat = ism.flatten(disk)
        assert np.abs(flat.log_length_ratios()).max() < 0.01
    more = ism.repair_disk(v, f, cut=loops + 2)
    assert more.actions[-1].endswith(f"{loops} boundary loops and 2 tips")
    assert len(more.v) > len(disk.v)
    ism.check_disk(ism.repair_disk(v, f, cut=[100, 130]))


def test_a_cut_of_a_disk_is_a_slit():
    disk = ism.repair_disk(V, F[1:], cut=2)
    assert "between 1 boundary loop and 1 tip" in disk.actions[-1]
    assert np.array_equal(np.sort(disk.vertex_source[disk.f], axis=1), np.sort(F[1:], axis=1))


def test_more_tips_than_vertices_are_refused_at_once():
    v, f = ism.samples.sphere(42)
    with pytest.raises(
        ValueError, match="cut is 1000000000; give at most the number of vertices, 42"
    ):
        ism.repair_disk(v, f, cut=10**9)


def test_edges_to_cut_along_leave_the_largest_part_if_that_is_asked_for():
    v, f = ism.samples.sphere(162)
    ring = np.flatnonzero(np.abs(v @ [0, 0, 1]) < 1e-9)
    edges = f[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    belt = edges[np.isin(edges, ring).all(axis=1)]
    with pytest.raises(ism.MeshError, match="2 components"):
        ism.repair_disk(v, f, cut=belt)
    disk = ism.repair_disk(v, f, cut=belt, keep_largest=True)
    assert len(disk.f) == len(f) // 2
    assert {*ism.check_disk(disk).rim} == {*np.flatnonzero(np.isin(disk.vertex_source, ring))}
