"""Disks of surfaces that are none: holes but one filled, and closed surfaces cut open along a short tree."""

from __future__ import annotations

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
    with pytest.raises(
        ism.MeshError, match="open surface: 1 boundary loop, and a cut was asked for"
    ):
        ism.repair_disk(V, F[1:], cut=2)
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


def test_more_tips_than_vertices_are_refused_at_once():
    v, f = ism.samples.sphere(42)
    with pytest.raises(
        ValueError, match="cut is 1000000000; give at most the number of vertices, 42"
    ):
        ism.repair_disk(v, f, cut=10**9)
